"""RTAB-Map's database, an SQLite file; the tables and blobs of versions 0.11 to 0.23.

``Node``: ``id``, ``stamp`` (seconds), ``pose``: 3x4 float32, map to base. ``Data``: ``image``
(JPEG or PNG), ``depth`` (PNG of uint16 millimetres; PNG of four bytes a pixel: float32 metres; or
``DEPTHRVL``, uint32 width, height, RVL) and ``calibration``. ``Admin`` (since 0.17): ``opt_ids``
and ``opt_poses``, ids (int32) and poses (12 float32 each) after optimisation, packed.

A calibration is eleven int32 (version, 0 = one camera, width, height, numbers in K, D, R, P and in
the local transform), then these: float64 but for the transform, 3x4 float32 from the base to the
camera (OpenCV axes). What is packed is zlib, then int32 rows, columns and OpenCV's type. Integers
are little-endian.
"""

import sqlite3
import struct
import weakref
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.source import Camera

HEAD = struct.Struct("<11i")
TAIL = struct.Struct("<3i")
POSE_BYTES = 48
PACKED = {4: np.dtype("<i4"), 5: np.dtype("<f4")}
"""OpenCV's CV_32S and CV_32F."""
FRAMES = (
    "SELECT Node.id, Node.stamp, Node.pose FROM Node JOIN Data ON Data.id = Node.id "
    "WHERE length(Data.image) > 0 AND length(Data.depth) > 0 ORDER BY Node.id"
)
BLOBS = {"color": "image", "depth": "depth", "calibration": "calibration"}


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """Camera of the colour image, its ``distortion`` and where it sits: ``T_base_camera``."""

    camera: Camera
    distortion: Float64
    T_base_camera: Float64


@dataclass(frozen=True, slots=True, eq=False)
class NodeRow:
    """A node with images: its stamp, seconds, and odometry's pose of the base, if it has one."""

    stamp_s: float
    T_world_base: Float64 | None


class RtabmapDatabase:
    """A database that is only read."""

    def __init__(self, path: Path) -> None:
        """Open it; raise ``ValueError`` when it is none of RTAB-Map's."""
        self.path = path
        if not path.is_file():
            raise ValueError(f"{path}: no such file")
        address = f"{path.resolve().as_uri()}?mode=ro"
        self._file = sqlite3.connect(address, uri=True, check_same_thread=False)
        weakref.finalize(self, self._file.close)  # on whichever thread it is let go
        try:
            self.version = str((self._one("SELECT version FROM Admin") or ("?",))[0])
            rows = self._file.execute(FRAMES).fetchall()
        except sqlite3.Error as error:
            raise ValueError(f"{path}: no database of RTAB-Map: {error}") from error
        if not rows:
            raise ValueError(f"{path}: no node has colour and depth images")
        self.nodes = {int(n): NodeRow(float(s or 0), pose_of(p)) for n, s, p in rows}

    def blob(self, number: int, part: str) -> bytes:
        """Return an image or the calibration of a node; ``sqlite3.Error`` when it is damaged."""
        row = self._one(f"SELECT {BLOBS[part]} FROM Data WHERE id = {int(number)}")
        return bytes(row[0]) if row and row[0] else b""

    def optimised(self) -> Mapping[int, Float64]:
        """Return node -> T_world_base (4, 4) after optimisation, empty when there is none."""
        try:
            row = self._one("SELECT opt_ids, opt_poses FROM Admin")
        except sqlite3.Error:  # older than 0.17: no such columns
            return {}
        if not row or not row[0] or not row[1]:
            return {}
        try:
            ids, poses = _unpack(row[0]), _unpack(row[1]).reshape(-1, 3, 4)
        except ValueError as error:
            raise ValueError(f"{self.path}: Admin.opt_poses: {error}") from error
        if len(ids) != len(poses):
            raise ValueError(f"{self.path}: Admin: {len(ids)} opt_ids, {len(poses)} opt_poses")
        return {int(n): _four_rows(pose) for n, pose in zip(ids, poses, strict=True)}

    def _one(self, query: str) -> tuple[Any, ...] | None:
        row: tuple[Any, ...] | None = self._file.execute(query).fetchone()
        return row


def pose_of(data: bytes | None) -> Float64 | None:
    """Return a stored pose as (4, 4), ``None`` for one that is not known (absent, or all 0)."""
    if data is None or len(data) != POSE_BYTES:
        return None
    rows = np.frombuffer(data, "<f4").astype(np.float64).reshape(3, 4)
    return _four_rows(rows) if rows.any() else None


def calibration_of(data: bytes) -> Calibration:
    """Return what is in a calibration.

    Raises:
        ValueError: it is cut off, of several cameras or a stereo camera, or has no camera matrix.
    """
    if len(data) < HEAD.size:
        raise ValueError(f"calibration has {len(data)} bytes (of a version before 0.11.10?)")
    head = HEAD.unpack_from(data)
    kind, width, height = head[3:6]
    counts = head[6:11]
    if kind != 0:
        raise ValueError("calibration is of a stereo camera; recordings with depth are read")
    if min(counts) < 0 or counts[0] != 9 or counts[4] not in (0, 12):
        raise ValueError(f"calibration: expected 9 numbers in K, 12 in the transform, got {counts}")
    expected = HEAD.size + 8 * sum(counts[:4]) + 4 * counts[4]
    if len(data) != expected:
        raise ValueError(f"calibration has {len(data)} bytes, expected {expected} of one camera")
    K = np.frombuffer(data, "<f8", 9, HEAD.size).reshape(3, 3).copy()
    distortion = np.frombuffer(data, "<f8", counts[1], HEAD.size + 72).copy()
    T_base_camera = np.eye(4)
    if counts[4]:
        T_base_camera[:3] = np.frombuffer(data, "<f4", 12, expected - 48).reshape(3, 4)
    if not (np.isfinite(K).all() and K[0, 0] > 0 and K[1, 1] > 0 and width > 0 and height > 0):
        raise ValueError(f"calibration: no camera: {width}x{height}, {K.tolist()}")
    return Calibration(Camera(K, (width, height)), distortion, T_base_camera)


def _unpack(data: bytes) -> Any:
    """Return the flat array of packed ids or poses."""
    if len(data) < TAIL.size:
        raise ValueError(f"{len(data)} bytes")
    rows, columns, kind = TAIL.unpack_from(data, len(data) - TAIL.size)
    if kind not in PACKED:
        raise ValueError(f"OpenCV type {kind}, expected {sorted(PACKED)}")
    try:
        values = np.frombuffer(zlib.decompress(data[: -TAIL.size]), PACKED[kind])
    except zlib.error as error:
        raise ValueError(f"does not decompress: {error}") from error
    if len(values) != rows * columns:
        raise ValueError(f"{len(values)} numbers, expected {rows} x {columns}")
    return values


def _four_rows(rows: Any) -> Float64:
    T_world_base = np.eye(4)
    T_world_base[:3] = rows
    return T_world_base
