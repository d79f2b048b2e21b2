"""What RTAB-Map saved, a ``.db`` file, as a source: images, depth, calibration, optimised poses.

Poses are those after the last optimisation, saved when RTAB-Map closed the database; nodes that it
left out have none. Without any, odometry's are taken. Depth that is smaller than colour by a whole
factor is of the same camera, as RTAB-Map has it. What the calibration says of the lens is undone
for colour; RTAB-Map's depth is registered to the image it stores.
"""

import sqlite3
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import ClassVar

import cv2
import numpy as np

from sceneq_core.arrays import Array, Float64, UInt8, UInt16
from sceneq_core.ingest.transforms import nearest_rigid, rigid_defect
from sceneq_core.ingest.undistortion import EQUIDISTANT, Lens, Undistortion
from sceneq_nodes import _image_file
from sceneq_nodes._camera_files import nominal_stamps_ns
from sceneq_nodes._frame_files import BadFileError
from sceneq_nodes._image_file import decode_rgb
from sceneq_nodes._recorded_source import RecordedParams, RecordedSource, Recording, Size
from sceneq_nodes._resized import resized
from sceneq_nodes._rvl import decode_rvl
from sceneq_nodes.datasets.rtabmap_database import (
    Calibration,
    RtabmapDatabase,
    calibration_of,
)

RVL, RVL_HEAD = b"DEPTHRVL", 16
MM_PER_M = np.float32(1000.0)


@dataclass(frozen=True, slots=True)
class RtabmapParams(RecordedParams):
    """``path`` of the database; else as of every recording."""


class RtabmapSource(RecordedSource):
    """Nodes with images, in the order of their ids, which are ``seq``."""

    Params: ClassVar[type] = RtabmapParams

    def __init__(self, params: RtabmapParams) -> None:
        """Read nodes and poses; raise ``ValueError`` on a file that cannot be played."""
        super().__init__(params, _recording(Path(params.path)))


class NodeFiles:
    """The images and poses of a database, as ``Files`` of a recording."""

    def __init__(self, database: RtabmapDatabase) -> None:
        self._database = database
        self.numbers = sorted(database.nodes)
        odometry = {n: node.T_world_base for n, node in database.nodes.items()}
        self._T_world_base = dict(database.optimised()) or odometry
        self.has_poses = any(T is not None for T in self._T_world_base.values())
        self.calibration = self._first_calibration()

    def path(self, number: int, part: str) -> Path:
        """Return the file, with the place in it."""
        return self._database.path / "Data" / str(number) / part

    def image(self, number: int, part: str) -> tuple[bytes, Size]:
        """Return the stored bytes of an image and its (width, height)."""
        data, path = self._blob(number, part), self.path(number, part)
        try:
            return data, _depth_size(data) if part == "depth" else _image_file.header(data).size
        except ValueError as error:
            raise BadFileError(path, str(error)) from error

    def pose(self, number: int) -> Float64:
        """Return T_world_camera (4, 4) of the node's camera."""
        T_world_base, path = self._T_world_base.get(number), self.path(number, "pose")
        if T_world_base is None:
            raise BadFileError(path, "the optimised graph has no pose for it")
        calibration = self._calibration(number)
        if not np.array_equal(calibration.camera.K, self.calibration.camera.K):
            raise BadFileError(path, "calibrated otherwise than the first node")
        for pose in (T_world_base, calibration.T_base_camera):
            if defect := rigid_defect(pose):
                raise BadFileError(path, defect)
        return nearest_rigid(T_world_base) @ nearest_rigid(calibration.T_base_camera)

    def _calibration(self, number: int) -> Calibration:
        try:
            return calibration_of(self._blob(number, "calibration"))
        except ValueError as error:
            raise BadFileError(self.path(number, "calibration"), str(error)) from error

    def _first_calibration(self) -> Calibration:
        try:
            return self._calibration(self.numbers[0])
        except BadFileError as error:
            raise ValueError(str(error)) from error

    def _blob(self, number: int, part: str) -> bytes:
        try:
            return self._database.blob(number, part)
        except sqlite3.Error as error:
            raise BadFileError(self.path(number, part), str(error)) from error


def _recording(path: Path) -> Recording:
    database = RtabmapDatabase(path)
    files = NodeFiles(database)
    calibration = files.calibration
    try:
        color_size, depth_size = (files.image(files.numbers[0], p)[1] for p in ("color", "depth"))
    except BadFileError as error:
        raise ValueError(str(error)) from error
    if color_size != calibration.camera.size:
        raise ValueError(f"{path}: calibrated for {calibration.camera.size}, images: {color_size}")
    straight = partial(_undistorted, undistortion=_undistortion(calibration))
    return Recording(
        name=path.resolve().stem,
        files=files,
        stamps_ns=_stamps_ns(database),
        color_camera=calibration.camera,
        depth_camera=resized(calibration.camera, depth_size)
        if depth_size != color_size
        else calibration.camera,
        T_color_depth=np.eye(4),
        color_size=color_size,
        depth_size=depth_size,
        decode_rgb=straight if calibration.distortion.any() else None,
        decode_depth_mm=_decode_depth_mm,
    )


def _stamps_ns(database: RtabmapDatabase) -> dict[int, int]:
    """Return the stamps of the nodes, those of a steady rate when they do not grow."""
    stamps = {n: round(1e9 * node.stamp_s) for n, node in sorted(database.nodes.items())}
    grow = (np.diff(list(stamps.values())) > 0).all()
    return stamps if grow else nominal_stamps_ns(list(stamps))


def _undistortion(calibration: Calibration) -> Undistortion:
    camera, d = calibration.camera, calibration.distortion
    if len(d) == 6:  # of a fisheye lens: k1 k2 p1 p2 k3 k4, without p1 and p2
        return Undistortion(Lens(camera.K, camera.size, EQUIDISTANT, d[[0, 1, 4, 5]]))
    model = "rational_polynomial" if len(d) > 5 else "plumb_bob"
    return Undistortion(Lens(camera.K, camera.size, model, d))


def _undistorted(data: bytes, undistortion: Undistortion) -> UInt8:
    return undistortion.rgb(decode_rgb(data))


def _depth_size(data: bytes) -> Size:
    if data.startswith(RVL):
        if len(data) < RVL_HEAD:
            raise ValueError("depth is cut off")
        return int.from_bytes(data[8:12], "little"), int.from_bytes(data[12:16], "little")
    header = _image_file.header(data)
    if not header.is_depth and (header.bits, header.channels) != (8, 4):
        raise ValueError(f"depth with {header.bits} bits a channel, {header.channels} channels")
    return header.size


def _decode_depth_mm(data: bytes) -> UInt16:
    if data.startswith(RVL):
        return decode_rvl(data[RVL_HEAD:], _depth_size(data))
    if _image_file.header(data).is_depth:
        return _image_file.decode_depth_mm(data)
    pixels: Array | None = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if pixels is None or pixels.dtype != np.uint8 or pixels.shape[2:] != (4,):
        raise ValueError("depth does not decode to four bytes a pixel")
    depth_m = np.ascontiguousarray(pixels).view("<f4")[..., 0]
    depth_mm = np.rint(depth_m * MM_PER_M)
    held = (depth_mm > 0) & (depth_mm < np.iinfo(np.uint16).max)  # also not NaN
    return np.where(held, depth_mm, 0).astype(np.uint16)
