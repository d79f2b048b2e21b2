"""From source frames to posed keyframes in one camera."""

from dataclasses import dataclass

from sceneq_core.arrays import Float64
from sceneq_core.frame import Frame, depth_from_mm
from sceneq_core.ingest.keyframes import KeyframePolicy
from sceneq_core.ingest.odometry import Odometry
from sceneq_core.ingest.registration import DepthRegistration
from sceneq_core.ingest.source import RawFrame, Skipped, Source
from sceneq_core.ingest.transforms import inverse, nearest_rigid, rigid_defect

GIVEN = "given"


@dataclass(frozen=True, slots=True)
class Ingested:
    """What became of a source frame.

    ``T_world_camera`` (4, 4) is the pose of the COLOUR camera, ``pose_source`` is ``given`` or
    the kind of the odometry, ``keyframe`` is ``None`` for a frame that stays out of the map.
    """

    seq: int
    stamp_ns: int
    T_world_camera: Float64
    pose_source: str
    keyframe: Frame | None


class Ingestor:
    """Finds the pose of every frame and turns due ones into keyframes.

    The node and ``sceneq map`` both feed their frames through this, so both maps see the same.
    """

    def __init__(self, source: Source, odometry: Odometry, keyframes: KeyframePolicy) -> None:
        self._color_camera = source.color_camera
        self._depth_camera = source.depth_camera
        self._T_depth_color = inverse(source.T_color_depth)
        self._registration = DepthRegistration(
            source.depth_camera, source.color_camera, source.T_color_depth
        )
        self._odometry = odometry
        self._keyframes = keyframes

    def ingest(self, raw: RawFrame) -> Ingested | Skipped:
        """Take the next frame; ``Skipped`` when its pose or a needed image is unusable."""
        T_world_depth = self._depth_pose(raw)
        if isinstance(T_world_depth, Skipped):
            return T_world_depth
        T_world_camera = T_world_depth @ self._T_depth_color
        keyframe = self._keyframe(raw, T_world_camera)
        if isinstance(keyframe, Skipped):
            return keyframe
        pose_source = self._odometry.kind if raw.T_world_camera is None else GIVEN
        return Ingested(raw.seq, raw.stamp_ns, T_world_camera, pose_source, keyframe)

    def _depth_pose(self, raw: RawFrame) -> Float64 | Skipped:
        if raw.T_world_camera is not None:
            # Pose files are rounded; what leaves here must stay rigid after a product.
            return nearest_rigid(raw.T_world_camera)
        depth_mm = raw.read_depth_mm()
        if isinstance(depth_mm, Skipped):
            return depth_mm
        T_world_depth = self._odometry.register(depth_mm, self._depth_camera.K, raw.stamp_ns)
        defect = "too little depth" if T_world_depth is None else rigid_defect(T_world_depth)
        if T_world_depth is None or defect:
            return Skipped(raw.seq, self._odometry.kind, f"no pose: {defect}")
        return T_world_depth

    def _keyframe(self, raw: RawFrame, T_world_camera: Float64) -> Frame | Skipped | None:
        if not self._keyframes.is_due(T_world_camera):
            return None
        rgb, depth_mm = raw.read_rgb(), raw.read_depth_mm()
        if isinstance(rgb, Skipped):
            return rgb
        if isinstance(depth_mm, Skipped):
            return depth_mm
        self._keyframes.took(T_world_camera)
        return Frame(
            seq=raw.seq,
            stamp_ns=raw.stamp_ns,
            rgb=rgb,
            depth_m=depth_from_mm(self._registration.register(depth_mm)),
            K=self._color_camera.K,
            T_world_camera=T_world_camera,
        )
