"""From source frames to posed keyframes in one camera."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.frame import Frame, depth_from_mm
from sceneq_core.ingest.keyframes import KeyframePolicy
from sceneq_core.ingest.odometry import Odometry
from sceneq_core.ingest.pose_graph import PoseGraph
from sceneq_core.ingest.registration import DepthRegistration
from sceneq_core.ingest.shading import Shading, shading
from sceneq_core.ingest.source import RawFrame, Skipped, Source
from sceneq_core.ingest.transforms import inverse, nearest_rigid, rigid_defect

GIVEN = "given"
EXACT = 1e-14
"""How far R^T R is from the identity after ``nearest_rigid``, at most."""


@dataclass(frozen=True, slots=True)
class Ingested:
    """What became of a source frame.

    ``T_world_camera`` (4, 4) is the pose of the COLOUR camera, ``pose_source`` is ``given`` or
    the kind of the odometry, ``keyframe`` is ``None`` for a frame that stays out of the map.
    ``corrected`` are all poses (of the colour camera, by seq) that differ from those ingested
    before, when this keyframe brought news of them, else empty.
    """

    seq: int
    stamp_ns: int
    T_world_camera: Float64
    pose_source: str
    keyframe: Frame | None
    corrected: Mapping[int, Float64] = field(default_factory=dict)


class Ingestor:
    """Finds the pose of every frame and turns due ones into keyframes.

    The node and ``sceneq map`` both feed their frames through this, so both maps see the same.
    """

    def __init__(
        self,
        source: Source,
        keyframes: KeyframePolicy,
        odometry: Odometry | None = None,
        graph: PoseGraph | None = None,
    ) -> None:
        """Take the cameras of ``source``; ``graph`` keeps what ``odometry`` says from drifting.

        Raises:
            ValueError: nothing gives poses.
        """
        if odometry is None and not source.has_poses:
            raise ValueError(f"{source.name} has no poses: it needs an odometry")
        self._color_camera = source.color_camera
        self._depth_camera = source.depth_camera
        self._T_color_depth = source.T_color_depth
        self._T_depth_color = inverse(source.T_color_depth)
        self._registration = DepthRegistration(
            source.depth_camera, source.color_camera, source.T_color_depth
        )
        self._keyframes = keyframes
        self._odometry, self._graph = odometry, graph

    def ingest(self, raw: RawFrame) -> Ingested | Skipped:
        """Take the next frame; ``Skipped`` when its pose or a needed image is unusable."""
        if self._odometry is not None:
            return self._estimate(self._odometry, raw)
        T_world_depth = _given(raw)
        if isinstance(T_world_depth, Skipped):
            return T_world_depth
        T_world_camera = T_world_depth @ self._T_depth_color
        keyframe = self._keyframe(raw, T_world_camera)
        if isinstance(keyframe, Skipped):
            return keyframe
        corrected = {seq: T @ self._T_depth_color for seq, T in raw.corrected.items()}
        return Ingested(raw.seq, raw.stamp_ns, T_world_camera, GIVEN, keyframe, corrected)

    def _estimate(self, odometry: Odometry, raw: RawFrame) -> Ingested | Skipped:
        """Take a frame whose pose odometry has to find; the graph corrects it, and older ones."""
        depth_mm = raw.read_depth_mm()
        if isinstance(depth_mm, Skipped):
            return depth_mm
        K, shading = self._depth_camera.K, self._shading(raw)
        T_odometry = odometry.register(depth_mm, K, raw.stamp_ns, shading)
        if T_odometry is None:
            return Skipped(raw.seq, odometry.kind, "no pose: tracking lost, or too little depth")
        graph = self._graph
        T_world_depth = T_odometry if graph is None else graph.pose(T_odometry)
        keyframe = self._keyframe(raw, T_world_depth @ self._T_depth_color)
        if isinstance(keyframe, Skipped):
            return keyframe
        corrected = {}
        if keyframe is not None and graph is not None:
            T_world_depth = graph.add(raw.seq, T_odometry, depth_mm, K, shading)
            corrected = {seq: T @ self._T_depth_color for seq, T in graph.corrections().items()}
            keyframe = replace(keyframe, T_world_camera=T_world_depth @ self._T_depth_color)
        pose = T_world_depth @ self._T_depth_color
        return Ingested(raw.seq, raw.stamp_ns, pose, odometry.kind, keyframe, corrected)

    def _shading(self, raw: RawFrame) -> Shading | None:
        rgb = raw.read_rgb()
        if isinstance(rgb, Skipped):
            return None
        return shading(rgb, self._color_camera, self._T_color_depth)

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
    # Recorded poses are rounded; what leaves here must stay rigid after a product. One that is
    # exact already is left alone, so that what was ingested once comes out again bit by bit.
    R_world_camera = raw.T_world_camera[:3, :3]
    is_exact = np.abs(R_world_camera.T @ R_world_camera - np.eye(3)).max() < EXACT
    return raw.T_world_camera if is_exact else nearest_rigid(raw.T_world_camera)
