"""Poses for streams that have none."""

from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

from sceneq_core.arrays import Float64, UInt16
from sceneq_core.checks import need_positive
from sceneq_core.depth import pixel_rays
from sceneq_core.ingest.shading import Shading
from sceneq_core.ingest.transforms import nearest_rigid


class Odometry(Protocol):
    """Estimates how the depth camera moves; the world frame is its first pose.

    ``kind`` names the method in the poses that are published.
    """

    kind: str

    def register(
        self, depth_mm: UInt16, K: Float64, stamp_ns: int, shading: Shading | None = None
    ) -> Float64 | None:
        """Return T_world_camera (4, 4) of the next depth image, ``None`` when it cannot tell.

        ``shading`` is that of the picture taken at the same time.
        """


@dataclass(frozen=True, slots=True)
class KissIcpParams:
    """Lengths in metres.

    ``voxel_m`` is the resolution of the local map; ``initial_threshold_m`` how far apart
    matching points may be before the motion is known; ``min_motion_m`` the deviation from
    constant velocity below which that threshold does not adapt; ``max_range_m`` bounds both
    the depth used and the local map; of ``stride`` x ``stride`` pixels one is used.
    ``min_points`` valid pixels are the least that can fix six degrees of freedom robustly.
    """

    voxel_m: float = 0.1
    initial_threshold_m: float = 0.3
    min_motion_m: float = 0.02
    max_range_m: float = 10.0
    stride: int = 2
    min_points: int = 500

    def __post_init__(self) -> None:
        need_positive(self, *self.__dataclass_fields__)


class KissIcpOdometry:
    """KISS-ICP (Vizzo et al. 2023, DOI 10.1109/LRA.2023.3236571) on back-projected depth."""

    Params: ClassVar[type] = KissIcpParams
    kind = "kiss_icp"

    def __init__(self, params: KissIcpParams) -> None:
        self.params = params
        self._icp = kiss_icp(params)
        self._rays = _Rays(params.stride)

    def register(
        self, depth_mm: UInt16, K: Float64, stamp_ns: int, shading: Shading | None = None
    ) -> Float64 | None:
        """Return T_world_camera (4, 4) of the depth camera; ``None`` with too little depth.

        Depth images are taken as equally spaced in time: KISS-ICP predicts a constant motion per
        image, and the threshold adapts to what the prediction misses.
        """
        points = self._rays.points(depth_mm, K)
        if len(points) < self.params.min_points:
            return None
        self._icp.register_frame(points, timestamps=np.zeros(0))
        # A product of many rotations drifts away from being one.
        return nearest_rigid(np.array(self._icp.last_pose))


class _Rays:
    """Back-projection of every ``stride``-th pixel; keeps the rays of the last camera."""

    def __init__(self, stride: int) -> None:
        self._stride = stride
        self._camera: tuple[bytes, tuple[int, ...]] | None = None
        self._rays = np.zeros((0, 0, 3))  # (H / stride, W / stride, 3), z = 1

    def points(self, depth_mm: UInt16, K: Float64) -> Float64:
        """Return float64 (N, 3), metres in the depth camera."""
        camera = (K.tobytes(), depth_mm.shape)
        if camera != self._camera:
            x, y = pixel_rays(K, depth_mm.shape, self._stride)
            self._rays = np.stack(np.broadcast_arrays(x[None], y[:, None], 1.0), axis=-1)
            self._camera = camera
        depth_m = depth_mm[:: self._stride, :: self._stride] * 1e-3
        valid = depth_m > 0
        points: Float64 = self._rays[valid] * depth_m[valid][:, None]
        return points


def kiss_icp(params: KissIcpParams, min_range_m: float = 0.0) -> Any:
    """Return a KISS-ICP pipeline with every setting given, so that no environment variable counts.

    One thread: the sums of a parallel reduction depend on how the work was divided.
    """
    from kiss_icp.config import KISSConfig
    from kiss_icp.config.config import (
        AdaptiveThresholdConfig,
        DataConfig,
        MappingConfig,
        RegistrationConfig,
    )
    from kiss_icp.kiss_icp import KissICP

    return KissICP(
        KISSConfig(
            data=DataConfig(max_range=params.max_range_m, min_range=min_range_m, deskew=False),
            registration=RegistrationConfig(max_num_threads=1),
            mapping=MappingConfig(voxel_size=params.voxel_m),
            adaptive_threshold=AdaptiveThresholdConfig(
                initial_threshold=params.initial_threshold_m, min_motion_th=params.min_motion_m
            ),
        )
    )
