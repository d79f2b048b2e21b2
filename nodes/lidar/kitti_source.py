"""Source kind ``kitti``: a LiDAR with a colour camera, in the layout of KITTI odometry.

Each scan gives the depth of the image taken with it, and, where poses are not given, its pose:
KISS-ICP on whole scans.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from sceneq_core.arrays import Float32, Float64, UInt8, UInt16
from sceneq_core.checks import need_at_least
from sceneq_core.ingest.lidar_depth import LidarDepthParams, lidar_depth_mm
from sceneq_core.ingest.lidar_odometry import LidarOdometry, LidarOdometryParams
from sceneq_core.ingest.source import Camera, RawFrame, RefusedError, Skipped
from sceneq_core.ingest.transforms import inverse
from sceneq_nodes._image_file import decode_rgb, header
from sceneq_nodes.lidar.kitti_files import (
    image_files,
    read_calibration,
    read_poses,
    read_scan,
    read_times_ns,
    scan_file,
)


@dataclass(frozen=True, slots=True)
class KittiParams:
    """``path`` of a sequence such as ``sequences/07``; every ``step``-th of its frames.

    Without ``use_poses``, or without a file of them, poses come from the scans by ``odometry``;
    the world is then the first pose of the LiDAR, z up. ``depth``: how a scan becomes a depth
    image. A LiDAR sees far: the mapper needs ``voxel_size_m`` 0.1 and a larger ``max_depth_m``.
    """

    path: str
    step: int = 1
    use_poses: bool = True
    odometry: LidarOdometryParams = field(default_factory=LidarOdometryParams)
    depth: LidarDepthParams = field(default_factory=LidarDepthParams)

    def __post_init__(self) -> None:
        need_at_least(self, 1, "step")


class KittiSource:
    """Frames of one drive; ``seq`` is the number in the names of the files."""

    Params: ClassVar[type] = KittiParams
    has_poses = True

    def __init__(self, params: KittiParams) -> None:
        """Read calibration, times and poses; ``ValueError`` on what cannot be played."""
        folder = Path(params.path)
        self.name = folder.resolve().name
        self._params, self._folder = params, folder
        self._images = image_files(folder)
        K, self._T_camera_lidar, T_camera_cam0 = read_calibration(folder)
        count = max(self._images) + 1
        self._stamps_ns = read_times_ns(folder, count)
        self._poses = read_poses(folder, T_camera_cam0, count) if params.use_poses else []
        self.color_camera = self.depth_camera = Camera(K, _size(self._images.values()))
        self.T_color_depth = np.eye(4)

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(range(0, len(self._images), self._params.step))

    def frames(self) -> Iterator[RawFrame | Skipped]:
        """Yield the drive from its first frame."""
        odometry = None if self._poses else LidarOdometry(self._params.odometry)
        for number in list(self._images)[:: self._params.step]:
            yield self._frame(number, odometry)

    def control(self, verb: str, arguments: Mapping[str, str]) -> dict[str, Any]:
        """Refuse: what is recorded is recorded."""
        raise RefusedError("a recording cannot be changed", "a simulation can: sceneq up --sim")

    def _frame(self, number: int, odometry: LidarOdometry | None) -> RawFrame | Skipped:
        image = self._images[number]
        scan = scan_file(self._folder, image)
        try:
            points_lidar = read_scan(scan)
        except ValueError as error:
            return Skipped(number, str(scan), str(error))
        T_world_camera = self._pose(number, points_lidar, odometry)
        if T_world_camera is None:
            return Skipped(number, str(scan), f"{len(points_lidar)} points are too few for a pose")
        return RawFrame(
            seq=number,
            stamp_ns=self._stamps_ns[number],
            T_world_camera=T_world_camera,
            read_rgb=partial(_read_rgb, number, image, self.color_camera.size),
            read_depth_mm=partial(self._depth_mm, points_lidar),
        )

    def _pose(
        self, number: int, points_lidar: Float32, odometry: LidarOdometry | None
    ) -> Float64 | None:
        if odometry is None:
            return self._poses[number]
        T_world_lidar = odometry.register(points_lidar)
        return None if T_world_lidar is None else T_world_lidar @ inverse(self._T_camera_lidar)

    def _depth_mm(self, points_lidar: Float32) -> UInt16:
        return lidar_depth_mm(
            points_lidar, self._T_camera_lidar, self.depth_camera, self._params.depth
        )


def _read_rgb(number: int, path: Path, size: tuple[int, int]) -> UInt8 | Skipped:
    try:
        data = path.read_bytes()
        found = header(data).size
        if found != size:
            raise ValueError(
                f"image is {found[0]}x{found[1]}, the camera's are {size[0]}x{size[1]}"
            )
        return decode_rgb(data)
    except OSError as error:
        return Skipped(number, str(path), error.strerror or "cannot be read")
    except ValueError as error:
        return Skipped(number, str(path), str(error))


def _size(images: Any) -> tuple[int, int]:
    """Return the (width, height) of the first image that has one."""
    for path in images:
        try:
            return header(path.read_bytes()).size
        except (OSError, ValueError) as error:
            defect = f"{path}: {error}"
    raise ValueError(f"no image can be used; the last: {defect}")
