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

    def __init__(
        self, source: Source, keyframes: KeyframePolicy, odometry: Odometry | None = None
    ) -> None:
        """Take the cameras of ``source``; raise ``ValueError`` when nothing gives it poses."""
        if odometry is None and not source.has_poses:
            raise ValueError(f"{source.name} has no poses: it needs an odometry")
        self._color_camera = source.color_camera
        self._depth_camera = source.depth_camera
        self._T_depth_color = inverse(source.T_color_depth)
        self._registration = DepthRegistration(
            source.depth_camera, source.color_camera, source.T_color_depth
        )
        self._keyframes = keyframes
        self._odometry = odometry
        self._pose_source = odometry.kind if odometry else GIVEN

    def ingest(self, raw: RawFrame) -> Ingested | Skipped:
        """Take the next frame; ``Skipped`` when its pose or a needed image is unusable."""
        T_world_depth = self._register(self._odometry, raw) if self._odometry else _given(raw)
        if isinstance(T_world_depth, Skipped):
            return T_world_depth
        T_world_camera = T_world_depth @ self._T_depth_color
        keyframe = self._keyframe(raw, T_world_camera)
        if isinstance(keyframe, Skipped):
            return keyframe
        return Ingested(raw.seq, raw.stamp_ns, T_world_camera, self._pose_source, keyframe)

    def _register(self, odometry: Odometry, raw: RawFrame) -> Float64 | Skipped:
        depth_mm = raw.read_depth_mm()
        if isinstance(depth_mm, Skipped):
            return depth_mm
        T_world_depth = odometry.register(depth_mm, self._depth_camera.K, raw.stamp_ns)
        if T_world_depth is None:
            return Skipped(raw.seq, odometry.kind, "no pose: too little depth")
        return T_world_depth

    def _keyframe(self, raw: RawFrame, T_world_camera: Float64) -> Frame | Skipped | None:
        if not self._keyframes.is_due(T_world_camera, raw.stamp_ns):
            return None
        rgb, depth_mm = raw.read_rgb(), raw.read_depth_mm()
        if isinstance(rgb, Skipped):
            return rgb
        if isinstance(depth_mm, Skipped):
            return depth_mm
        self._keyframes.took(T_world_camera, raw.stamp_ns)
        return Frame(
            seq=raw.seq,
            stamp_ns=raw.stamp_ns,
            rgb=rgb,
            depth_m=depth_from_mm(self._registration.register(depth_mm)),
            K=self._color_camera.K,
            T_world_camera=T_world_camera,
        )


def _given(raw: RawFrame) -> Float64 | Skipped:
    if raw.T_world_camera is None:
        return Skipped(raw.seq, f"frame {raw.seq}", "no pose, in a source that promised them")
    defect = rigid_defect(raw.T_world_camera)
    if defect:
        return Skipped(raw.seq, f"pose of frame {raw.seq}", defect)
    # Recorded poses are rounded; what leaves here must stay rigid after a product.
    return nearest_rigid(raw.T_world_camera)
