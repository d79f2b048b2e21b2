"""The cameras and stamps of a recorded folder; everything wrong in them is a ``ValueError``."""

import json
from pathlib import Path

import numpy as np

from sceneq_core.arrays import Array, Float64
from sceneq_core.ingest.transforms import rigid_defect

INTRINSICS = "camera-intrinsics.txt"
COLOR = "camera-color.json"
STAMPS = "stamps.txt"
NOMINAL_HZ = 30
"""Capture rate of the recordings that come without stamps (Kinect)."""


def read_intrinsics(folder: Path) -> Float64:
    """Return K (3, 3) of the depth camera; the file may hold more rows and columns."""
    path = folder / INTRINSICS
    try:
        rows = [[float(v) for v in line.split()] for line in path.read_text().splitlines()]
        return _pinhole([row for row in rows if row])
    except OSError as error:
        hint = "a text file with the 3x3 camera matrix in pixels"
        raise ValueError(f"{path}: cannot be read ({error.strerror}); add {hint}") from error
    except ValueError as error:
        raise ValueError(f"{path}: {error}; expected the 3x3 camera matrix in pixels") from error


def read_color_camera(folder: Path) -> tuple[Float64, Float64] | None:
    """Return K (3, 3) and T_color_depth (4, 4), ``None`` when depth is registered already."""
    path = folder / COLOR
    if not path.exists():
        return None
    try:
        camera = json.loads(path.read_text())
        T_color_depth = np.array(camera["T_color_depth"], dtype=np.float64)
        if defect := rigid_defect(T_color_depth):
            raise ValueError(f"T_color_depth: {defect}")
        return _pinhole(camera["K"]), T_color_depth
    except (OSError, ValueError, TypeError, KeyError, RecursionError) as error:
        expected = '{"K": 3x3, "T_color_depth": 4x4}'
        raise ValueError(f"{path}: {error}; expected {expected}") from error


def read_stamps_ns(folder: Path, numbers: list[int]) -> dict[int, int]:
    """Return the capture time of every frame number.

    Without ``stamps.txt`` a frame numbered n was captured n / 30 s after the start. Its lines,
    seconds, belong to the frames in order or, when there are more, to the frame numbers.
    """
    path = folder / STAMPS
    if not path.exists():
        return nominal_stamps_ns(numbers)
    try:
        seconds = [float(line) for line in path.read_text().split()]
    except ValueError as error:
        raise ValueError(f"{path}: {error}; expected one number of seconds a line") from error
    lines = dict(zip(numbers, seconds, strict=True)) if len(seconds) == len(numbers) else None
    if lines is None and numbers[-1] < len(seconds):
        lines = {n: seconds[n] for n in numbers}
    if lines is None:
        raise ValueError(f"{path}: {len(seconds)} stamps for {len(numbers)} frames")
    stamps = list(lines.values())
    if not np.isfinite(stamps).all() or (np.diff(stamps) <= 0).any():
        raise ValueError(f"{path}: stamps must be finite and grow")
    return {n: round(s * 1e9) for n, s in lines.items()}


def nominal_stamps_ns(numbers: list[int]) -> dict[int, int]:
    """Return the capture times of frames without stamps: frame n was taken n / 30 s after 0."""
    return {n: round(n * 1_000_000_000 / NOMINAL_HZ) for n in numbers}


def _pinhole(rows: Array | list[list[float]]) -> Float64:
    values = np.array(rows, dtype=np.float64)
    if values.ndim != 2 or min(values.shape) < 3:
        raise ValueError(f"got shape {values.shape}")
    K: Float64 = values[:3, :3].copy()
    upright = K[0, 1] == K[1, 0] == K[2, 0] == K[2, 1] == 0 and K[2, 2] == 1
    if not (np.isfinite(K).all() and upright and K[0, 0] > 0 and K[1, 1] > 0):
        raise ValueError(f"no pinhole camera without skew: {K.tolist()}")
    return K
