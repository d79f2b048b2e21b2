"""The files of a sequence of KITTI odometry (Geiger et al. 2012, DOI 10.1109/CVPR.2012.6248074).

``image_2/000000.png``, ``velodyne/000000.bin`` (float32 x y z reflectance), ``calib.txt`` (``P2:``
3x4, pixels of rectified points of camera 0; ``Tr:`` 3x4, LiDAR to camera 0), ``times.txt``
(seconds), and ``poses.txt`` (3x4 of camera 0 in its first one) or, where KITTI keeps it,
``../../poses/<sequence>.txt``.
"""

from pathlib import Path

import numpy as np

from sceneq_core.arrays import Float32, Float64
from sceneq_core.ingest.transforms import inverse, rigid_defect
from sceneq_nodes._matrix_file import read_lines, read_rows

IMAGES, SCANS, CALIBRATION, TIMES = "image_2", "velodyne", "calib.txt", "times.txt"
FLOATS_PER_POINT = 4
TOO_FAR_M = 1e5
"""No LiDAR reaches that far; also what is not finite."""
CAMERA, LIDAR = "P2", "Tr"


def image_files(folder: Path) -> dict[int, Path]:
    """Return frame number -> colour image, of the frames that have a scan, in order."""
    scans = {int(path.stem) for path in (folder / SCANS).glob("*.bin") if path.stem.isdigit()}
    images = [path for path in (folder / IMAGES).glob("*.*") if path.stem.isdigit()]
    found = {int(path.stem): path for path in images if int(path.stem) in scans}
    if not found:
        raise ValueError(f"{folder}: no frame has {IMAGES}/*.png and {SCANS}/*.bin")
    return dict(sorted(found.items()))


def scan_file(folder: Path, image: Path) -> Path:
    """Return the scan that belongs to an image."""
    return folder / SCANS / f"{image.stem}.bin"


def read_scan(path: Path) -> Float32:
    """Return points_lidar, float32 (N, 3), metres; ``ValueError`` for a file that is no scan."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ValueError(error.strerror or "cannot be read") from error
    if not data or len(data) % (4 * FLOATS_PER_POINT):
        raise ValueError(f"{len(data)} bytes are no points of {FLOATS_PER_POINT} floats")
    points = np.frombuffer(data, "<f4").reshape(-1, FLOATS_PER_POINT)[:, :3]
    return np.asarray(points[(np.abs(points) < TOO_FAR_M).all(axis=1)], np.float32)


def read_calibration(folder: Path) -> tuple[Float64, Float64, Float64]:
    """Return K (3, 3) of camera 2, T_camera_lidar and T_camera_cam0 (4, 4)."""
    path = folder / CALIBRATION
    rows = dict(_named_rows(path))
    for name in (CAMERA, LIDAR):
        if name not in rows:
            raise ValueError(f"{path}: no line '{name}:' with 12 numbers")
    projection, T_cam0_lidar = rows[CAMERA], np.eye(4)
    K = projection[:, :3].copy()
    if not (K[0, 0] > 0 and K[1, 1] > 0 and K[2].tolist() == [0, 0, 1]):
        raise ValueError(f"{path}: {CAMERA} is no projection of a pinhole camera")
    T_camera_cam0 = np.eye(4)
    T_camera_cam0[:3, 3] = np.linalg.solve(K, projection[:, 3])
    T_cam0_lidar[:3] = rows[LIDAR]
    if defect := rigid_defect(T_cam0_lidar):
        raise ValueError(f"{path}: {LIDAR}: {defect}")
    return K, T_camera_cam0 @ T_cam0_lidar, T_camera_cam0


def read_times_ns(folder: Path, count: int) -> list[int]:
    """Return the capture times of the first ``count`` frames, nanoseconds, growing."""
    times_s = read_rows(folder / TIMES, 1)[:, 0]
    if len(times_s) < count or (np.diff(times_s) <= 0).any():
        raise ValueError(f"{folder / TIMES}: expected {count} growing times, got {len(times_s)}")
    return [round(float(time_s) * 1e9) for time_s in times_s]


def read_poses(folder: Path, T_camera_cam0: Float64, count: int) -> list[Float64]:
    """Return T_world_camera (4, 4) of camera 2 by frame number; [] when there is no file."""
    beside = folder / "poses.txt"
    path = beside if beside.exists() else folder.parent.parent / "poses" / f"{folder.name}.txt"
    if not path.exists():
        return []
    rows = read_rows(path, 12)
    if len(rows) < count:
        raise ValueError(f"{path}: {len(rows)} poses for {count} frames")
    poses = np.tile(np.eye(4), (len(rows), 1, 1))
    poses[:, :3] = rows.reshape(-1, 3, 4)
    T_cam0_camera = inverse(T_camera_cam0)
    return [T_world_cam0 @ T_cam0_camera for T_world_cam0 in poses]


def _named_rows(path: Path) -> list[tuple[str, Float64]]:
    found = []
    for line in read_lines(path):
        name, _, numbers = line.partition(":")
        try:
            values = np.array(numbers.split(), np.float64)
        except ValueError as error:
            raise ValueError(f"{path}: {name}: not numbers") from error
        if values.size == 12 and np.isfinite(values).all():
            found.append((name.strip(), values.reshape(3, 4)))
    return found
