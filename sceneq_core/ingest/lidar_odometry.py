"""How a LiDAR moves, from its scans alone."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sceneq_core.arrays import Float32, Float64
from sceneq_core.checks import need_at_least, need_positive
from sceneq_core.ingest.odometry import KissIcpParams, kiss_icp
from sceneq_core.ingest.transforms import nearest_rigid


@dataclass(frozen=True, slots=True)
class LidarOdometryParams:
    """Lengths in metres, as in ``KissIcpParams``; the defaults are those for a car outdoors.

    Indoors ``voxel_m`` 0.25 and ``max_range_m`` 30 fit better. Points nearer than ``min_range_m``
    are the vehicle itself.
    """

    voxel_m: float = 1.0
    initial_threshold_m: float = 2.0
    min_motion_m: float = 0.1
    min_range_m: float = 0.5
    max_range_m: float = 100.0
    min_points: int = 200

    def __post_init__(self) -> None:
        need_positive(self, "voxel_m", "initial_threshold_m", "min_motion_m", "max_range_m")
        need_at_least(self, 0, "min_range_m")
        need_at_least(self, 6, "min_points")
        if not self.max_range_m > self.min_range_m:
            raise ValueError(f"max_range_m: must exceed min_range_m, got {self.max_range_m}")


class LidarOdometry:
    """KISS-ICP (Vizzo et al. 2023, DOI 10.1109/LRA.2023.3236571) on whole scans.

    The world frame is the LiDAR's first pose. Scans are taken as they are: not deskewed.
    """

    Params: ClassVar[type] = LidarOdometryParams
    kind = "kiss_icp"

    def __init__(self, params: LidarOdometryParams) -> None:
        self._params = params
        self._icp = kiss_icp(
            KissIcpParams(
                voxel_m=params.voxel_m,
                initial_threshold_m=params.initial_threshold_m,
                min_motion_m=params.min_motion_m,
                max_range_m=params.max_range_m,
            ),
            min_range_m=params.min_range_m,
        )

    def register(self, points_lidar: Float32) -> Float64 | None:
        """Return T_world_lidar (4, 4) of the next scan (N, 3), metres; ``None`` if too sparse."""
        range_m = np.linalg.norm(points_lidar, axis=1)
        near, far = self._params.min_range_m, self._params.max_range_m
        points = points_lidar[(range_m > near) & (range_m < far)].astype(np.float64)
        if len(points) < self._params.min_points:
            return None
        self._icp.register_frame(points, timestamps=np.zeros(0))
        return nearest_rigid(np.array(self._icp.last_pose))
