"""Record3D's ``.r3d``: a zip with ``metadata`` (JSON) and ``rgbd/N.jpg``, ``N.depth``, ``N.conf``.

Depth is float32 metres and confidence uint8 (0 low, 1 medium, 2 high), both (dh, dw) and compressed
with LZFSE. Of the metadata is read: ``w``, ``h`` of the colour images, ``dw``, ``dh``, ``K`` of
colour in columns, ``fps``, ``frameTimestamps`` (seconds, newer versions) and ``poses``, of each
frame qx qy qz qw tx ty tz: camera to world in ARKit's axes, where the camera looks along -z and y
is up, in the world as well.
"""

import json
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sceneq_core.arrays import Float32, Float64
from sceneq_core.ingest.quaternion import rigid_from_quaternion
from sceneq_core.ingest.source import Camera
from sceneq_core.ingest.transforms import rigid_defect
from sceneq_nodes._camera_files import NOMINAL_HZ
from sceneq_nodes._frame_files import BadFileError, check_image
from sceneq_nodes._resized import resized

METADATA, FRAMES = "metadata", "rgbd"
SUFFIX = {"color": "jpg", "depth": "depth", "conf": "conf"}
OLD_DEPTH_SIZE = (192, 256)
"""Of recordings from before the metadata told it: LiDAR, upright."""

T_WORLD_ARKIT = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
"""ARKit's y, up, becomes z."""
T_ARKIT_CAMERA = np.diag([1.0, -1.0, -1.0, 1.0])
"""From the camera that looks along z, y down, to ARKit's."""

INSTALL = "depth in .r3d files is LZFSE: pip install 'sceneq[record3d]' (pyliblzfse)"


class Record3dFile:
    """The frames of an ``.r3d`` file; depth comes decompressed, weak measurements taken out."""

    def __init__(self, path: Path, min_confidence: int) -> None:
        """Read the metadata; raise ``ValueError`` naming what is wrong."""
        self._path = path
        self._min_confidence = min_confidence
        self._decompress = _lzfse()
        try:
            self._zip = zipfile.ZipFile(path)
            self._names = set(self._zip.namelist())
            metadata = json.loads(self._zip.read(METADATA))
        except (OSError, KeyError, ValueError, zipfile.BadZipFile) as error:
            raise ValueError(f"{path}: no Record3D file: {error}") from error
        stems = (Path(name).stem for name in self._names if name.endswith(".jpg"))
        self.numbers = sorted(int(stem) for stem in stems if stem.isdecimal())
        if not self.numbers:
            raise ValueError(f"{path}: no frames; expected rgbd/0.jpg, rgbd/0.depth, ...")
        try:
            self.color, self.depth = _cameras(metadata)
            self._poses = np.array(metadata.get("poses", []), np.float64).reshape(-1, 7)
            self.stamps_ns = _stamps_ns(metadata, self.numbers)
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{path}, {METADATA}: {error}") from error
        self.has_poses = len(self._poses) > 0

    def path(self, number: int, part: str) -> Path:
        """Return the file, with the place in it."""
        return self._path / FRAMES / f"{number}.{SUFFIX[part]}"

    def image(self, number: int, part: str) -> tuple[bytes, tuple[int, int]]:
        """Return the JPEG, or float32 metres with 0 for no measurement, and (width, height)."""
        if part == "color":
            data = self._read(number, part)
            return data, check_image(self.path(number, part), data, part)
        return self._depth_m(number).tobytes(), self.depth.size

    def pose(self, number: int) -> Float64:
        """Return T_world_camera (4, 4), z up in the world."""
        path = self._path / METADATA
        if number >= len(self._poses):
            raise BadFileError(path, f"no pose for frame {number}")
        T_world_camera = world_pose(self._poses[number])
        if defect := rigid_defect(T_world_camera):
            raise BadFileError(path, f"pose of frame {number}: {defect}")
        return T_world_camera

    def _depth_m(self, number: int) -> Float32:
        depth_m = self._array(number, "depth", np.dtype("<f4"))
        held = np.isfinite(depth_m) & (depth_m > 0)
        if self._min_confidence and f"{FRAMES}/{number}.conf" in self._names:
            held &= self._array(number, "conf", np.dtype("u1")) >= self._min_confidence
        return np.where(held, depth_m, np.float32(0))

    def _array(self, number: int, part: str, dtype: "np.dtype[Any]") -> Any:
        path, (width, height) = self.path(number, part), self.depth.size
        try:
            data = self._decompress(self._read(number, part))
        except Exception as error:  # the package raises its own, and says no class
            raise BadFileError(path, f"does not decompress: {error}") from error
        if len(data) != width * height * dtype.itemsize:
            raise BadFileError(path, f"{len(data)} bytes, expected {width}x{height} {dtype}")
        return np.frombuffer(data, dtype)

    def _read(self, number: int, part: str) -> bytes:
        path = self.path(number, part)
        try:
            return self._zip.read(f"{FRAMES}/{path.name}")
        except (KeyError, OSError, zipfile.BadZipFile) as error:
            raise BadFileError(path, f"not in the zip, or damaged: {error}") from error


def _cameras(metadata: Mapping[str, Any]) -> tuple[Camera, Camera]:
    K = np.array(metadata["K"], np.float64).reshape(3, 3).T
    size = int(metadata["w"]), int(metadata["h"])
    depth_size = OLD_DEPTH_SIZE
    if "dw" in metadata:
        depth_size = int(metadata["dw"]), int(metadata["dh"])
    if min(*size, *depth_size, K[0, 0], K[1, 1]) <= 0 or not np.isfinite(K).all():
        raise ValueError(f"K, w, h, dw, dh: no camera: {K.tolist()}, {size}, {depth_size}")
    color = Camera(K, size)
    return color, resized(color, depth_size)


def _stamps_ns(metadata: Mapping[str, Any], numbers: list[int]) -> dict[int, int]:
    """Return the stamps that are told where they grow, else those of a steady rate."""
    told = np.array(metadata.get("frameTimestamps", []), np.float64)
    if numbers[-1] < len(told) and (np.diff(told[numbers]) > 0).all():
        return {n: round(1e9 * (told[n] - told[numbers[0]])) for n in numbers}
    fps = float(metadata.get("fps") or NOMINAL_HZ)
    return {n: round(1e9 * n / fps) for n in numbers}


def world_pose(pose: Float64) -> Float64:
    """Return T_world_camera (4, 4), z up, of ARKit's qx qy qz qw tx ty tz; NaN when it is none."""
    length = float(np.linalg.norm(pose[:4]))
    if not (np.isfinite(pose).all() and length > 0.5):
        return np.full((4, 4), np.nan)
    T_arkit: Float64 = rigid_from_quaternion(pose[4:], pose[:4] / length)
    return T_WORLD_ARKIT @ T_arkit @ T_ARKIT_CAMERA


def _lzfse() -> Callable[[bytes], bytes]:
    try:
        import liblzfse
    except ImportError as error:
        raise ValueError(INSTALL) from error
    decompress: Callable[[bytes], bytes] = liblzfse.decompress
    return decompress
