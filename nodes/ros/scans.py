"""LiDAR scans in place of depth images: their odometry, and their depth in the colour camera."""

from typing import Any

from sceneq_core.arrays import Float64, UInt16
from sceneq_core.ingest.lidar_depth import LidarDepthParams, lidar_depth_mm
from sceneq_core.ingest.lidar_odometry import LidarOdometry, LidarOdometryParams
from sceneq_core.ingest.source import Camera, Skipped
from sceneq_core.ingest.transforms import inverse
from sceneq_nodes.ros.point_cloud import cloud_xyz
from sceneq_nodes.ros.troubles import Troubles
from sceneq_nodes.ros.typestore import WireError

KEPT = 200
"""Poses of so many scans wait for their images."""


class ScanOdometry:
    """Where the LiDAR was at every scan; each scan counts, whether an image goes with it or not."""

    def __init__(self, params: LidarOdometryParams, troubles: Troubles) -> None:
        self._params = params
        self._troubles = troubles
        self._odometry: LidarOdometry | None = None
        self._poses: dict[int, Float64] = {}

    def add(self, stamp_ns: int, message: Any) -> None:
        """Register the next scan; one that cannot be is a trouble."""
        try:
            points_lidar, _ = cloud_xyz(message)
        except WireError as error:
            self._troubles.note("bad_points", str(error))
            return
        if self._odometry is None:
            self._odometry = LidarOdometry(self._params)
        T_world_lidar = self._odometry.register(points_lidar)
        if T_world_lidar is None:
            text = f"{len(points_lidar)} points are too few for a pose"
            self._troubles.note("bad_points", text)
            return
        self._poses[stamp_ns] = T_world_lidar
        while len(self._poses) > KEPT:
            del self._poses[next(iter(self._poses))]

    def pose(self, stamp_ns: int, T_camera_lidar: Float64) -> Float64 | None:
        """Return T_world_camera (4, 4) at a scan, ``None`` when there is none for it."""
        T_world_lidar = self._poses.get(stamp_ns)
        return None if T_world_lidar is None else T_world_lidar @ inverse(T_camera_lidar)


def scan_depth_mm(
    message: Any,
    T_camera_lidar: Float64,
    camera: Camera,
    params: LidarDepthParams,
    where: tuple[int, str],
) -> UInt16 | Skipped:
    """Return the scan as depth, uint16 (H, W) millimetres, in ``camera``."""
    try:
        points_lidar, _ = cloud_xyz(message)
    except WireError as error:
        return Skipped(*where, str(error))
    return lidar_depth_mm(points_lidar, T_camera_lidar, camera, params)
