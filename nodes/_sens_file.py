"""ScanNet's ``.sens`` container, version 4: cameras in its head, then one record a frame.

Little endian. Head: uint32 version, uint64 length and bytes of the sensor's name, four float32 4x4
matrices (colour intrinsic, colour extrinsic, depth intrinsic, depth extrinsic), int32 colour and
depth compression, uint32 colour width and height, depth width and height, float32 depth units a
metre, uint64 number of frames. Frame: float32 4x4 camera to world, uint64 colour and depth stamp
(microseconds), uint64 size of the colour and of the depth bytes, then these.

A file is gigabytes: only the heads of its frames are read at first, images when they are needed.
"""

import struct
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from sceneq_core.arrays import Float64, UInt16
from sceneq_core.ingest.source import Camera
from sceneq_core.ingest.transforms import rigid_defect
from sceneq_nodes._frame_files import BadFileError, check_image
from sceneq_nodes._image_file import MAX_PIXELS

VERSION = 4
MATRIX = struct.Struct("<16f")
FRAME = struct.Struct("<16f4Q")
TAIL = struct.Struct("<ii4IfQ")
LENGTH = struct.Struct("<Q")
MAX_NAME = 4096
COLORS = {1: "png", 2: "jpeg"}
DEPTHS = {0: "raw", 1: "zlib"}


@dataclass(frozen=True, slots=True, eq=False)
class SensHead:
    """What holds for all frames; "rig" is what has the pose, the extrinsics are ``T_rig_*``."""

    color: Camera
    depth: Camera
    T_rig_color: Float64
    T_rig_depth: Float64
    depth_is_packed: bool
    units_per_m: float
    frames: int


@dataclass(frozen=True, slots=True, eq=False)
class _FrameHead:
    T_world_camera: Float64
    stamp_us: int
    color_at: int
    color_bytes: int
    depth_bytes: int


class SensFile:
    """The frames of a ``.sens`` file, numbered from 0; images come as they are stored."""

    def __init__(self, path: Path) -> None:
        """Read all heads; raise ``ValueError`` naming the file and the field that is wrong."""
        self._path = path
        try:
            with path.open("rb") as file:
                self.head = _read_head(file)
                length = path.stat().st_size
                self._frames = [_read_frame(file, n, length) for n in range(self.head.frames)]
        except OSError as error:
            raise ValueError(f"{path}: {error.strerror}") from error
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from error
        if not self._frames:
            raise ValueError(f"{path}: num_frames: 0")
        self.numbers = list(range(len(self._frames)))
        self.has_poses = True

    @property
    def stamps_us(self) -> list[int]:
        """Capture times of the colour images, microseconds, as they are stored."""
        return [frame.stamp_us for frame in self._frames]

    def path(self, number: int, part: str) -> Path:
        """Return the file, with the frame and part in it."""
        return self._path / str(number) / part

    def image(self, number: int, part: str) -> tuple[bytes, tuple[int, int]]:
        """Return the stored bytes of an image and its (width, height)."""
        frame, path = self._frames[number], self.path(number, part)
        if part == "depth":
            at = frame.color_at + frame.color_bytes
            return self._read(path, at, frame.depth_bytes), self.head.depth.size
        data = self._read(path, frame.color_at, frame.color_bytes)
        return data, check_image(path, data, part)

    def pose(self, number: int) -> Float64:
        """Return the rigid T_world_camera (4, 4) of a frame."""
        T_world_camera = self._frames[number].T_world_camera
        if defect := rigid_defect(T_world_camera):
            raise BadFileError(self.path(number, "pose"), defect)
        return T_world_camera

    def decode_depth_mm(self, data: bytes) -> UInt16:
        """Return uint16 (H, W) millimetres; raise ``ValueError`` when the bytes do not decode."""
        width, height = self.head.depth.size
        expected = 2 * width * height
        raw = _unpacked(data, expected) if self.head.depth_is_packed else data
        if len(raw) != expected:
            raise ValueError(f"depth has {len(raw)} bytes, expected {expected}")
        units = np.frombuffer(raw, "<u2").reshape(height, width)
        depth_mm = np.rint(units * (1000.0 / self.head.units_per_m))
        return np.where(depth_mm < np.iinfo(np.uint16).max, depth_mm, 0).astype(np.uint16)

    def _read(self, path: Path, at: int, length: int) -> bytes:
        try:
            with self._path.open("rb") as file:
                file.seek(at)
                return file.read(length)
        except OSError as error:
            raise BadFileError(path, error.strerror or "cannot be read") from error


def _read_head(file: BinaryIO) -> SensHead:
    (version,) = struct.unpack("<I", _take(file, 4, "version"))
    if version != VERSION:
        raise ValueError(f"version: expected {VERSION}, got {version}")
    (name_length,) = LENGTH.unpack(_take(file, LENGTH.size, "sensor name"))
    if name_length > MAX_NAME:
        raise ValueError(f"sensor name: {name_length} bytes long")
    _take(file, name_length, "sensor name")
    names = ("intrinsic_color", "extrinsic_color", "intrinsic_depth", "extrinsic_depth")
    matrices = [_matrix(_take(file, MATRIX.size, name), name) for name in names]
    tail = TAIL.unpack(_take(file, TAIL.size, "compression and sizes"))
    color, depth, color_w, color_h, depth_w, depth_h, units_per_m, frames = tail
    if color not in COLORS:
        raise ValueError(f"color_compression: {color}, known: {COLORS}")
    if depth not in DEPTHS:
        raise ValueError(f"depth_compression: {depth}, known: {DEPTHS}")
    if max(color_w * color_h, depth_w * depth_h) > MAX_PIXELS:
        raise ValueError(f"width and height: more than {MAX_PIXELS} pixels")
    if not units_per_m > 0:
        raise ValueError(f"depth_shift: expected above 0, got {units_per_m}")
    color_intrinsic, T_rig_color, depth_intrinsic, T_rig_depth = matrices
    return SensHead(
        color=Camera(color_intrinsic[:3, :3].copy(), (color_w, color_h)),
        depth=Camera(depth_intrinsic[:3, :3].copy(), (depth_w, depth_h)),
        T_rig_color=T_rig_color,
        T_rig_depth=T_rig_depth,
        depth_is_packed=DEPTHS[depth] == "zlib",
        units_per_m=units_per_m,
        frames=frames,
    )


def _read_frame(file: BinaryIO, number: int, length: int) -> _FrameHead:
    values = FRAME.unpack(_take(file, FRAME.size, f"frame {number}"))
    stamp_us, _, color_bytes, depth_bytes = values[16:]
    frame = _FrameHead(
        np.array(values[:16], np.float64).reshape(4, 4),
        stamp_us,
        file.tell(),
        color_bytes,
        depth_bytes,
    )
    if frame.color_at + color_bytes + depth_bytes > length:
        raise ValueError(f"frame {number}: the file is cut off")
    file.seek(color_bytes + depth_bytes, 1)
    return frame


def _unpacked(data: bytes, expected: int) -> bytes:
    """Return what zlib data hold, one byte too many at most."""
    try:
        return zlib.decompressobj().decompress(data, expected + 1)
    except zlib.error as error:
        raise ValueError(f"depth does not decompress: {error}") from error


def _matrix(data: bytes, name: str) -> Float64:
    matrix = np.array(MATRIX.unpack(data), np.float64).reshape(4, 4)
    if not np.isfinite(matrix).all():
        raise ValueError(f"{name}: not finite")
    return matrix


def _take(file: BinaryIO, count: int, what: str) -> bytes:
    data = file.read(count)
    if len(data) < count:
        raise ValueError(f"{what}: the file is cut off")
    return data
