"""Resizing with antialiasing, as the image processors of published encoders do it.

Towers were trained on pictures resized by Pillow: a kernel as wide as a target pixel, first along
rows, then along columns, rounded to 8 bits after each. OpenCV's kernels do not widen when a picture
shrinks, so what they give is aliased. (Newer Pillow does columns first where that is cheaper: of
smooth pictures some pixels then differ by one level.) Kernels: bilinear, and the cubic convolution
of R. Keys (1981, doi 10.1109/TASSP.1981.1163711) with a = -0.5.
"""

from typing import Literal

import numpy as np

from sceneq_core.arrays import Float32, Float64, Int64, UInt8

Kernel = Literal["bilinear", "bicubic"]
Window = tuple[int, int, int, int]

SUPPORT = {"bilinear": 1.0, "bicubic": 2.0}
"""Half the width of each kernel in pixels."""


def resample(
    rgb: UInt8, size: tuple[int, int], kernel: Kernel, window: Window | None = None
) -> UInt8:
    """Return ``rgb`` uint8 (h, w, 3) resized to ``size`` (height, width).

    With ``window`` (top, left, height, width) only that part of the result is computed: a strip a
    pixel high, fitted by its short edge, would be a huge picture.
    """
    top, left, height, width = window or (0, 0, *size)
    rows = _weights(rgb.shape[0] / size[0], rgb.shape[0], top + np.arange(height), kernel)
    columns = _weights(rgb.shape[1] / size[1], rgb.shape[1], left + np.arange(width), kernel)
    first, last = _reach(rows)
    planes = rgb[first:last].astype(np.float32).transpose(0, 2, 1).reshape(-1, rgb.shape[1])
    wide = _to_bytes(planes @ columns.T).astype(np.float32)
    tall = rows[:, first:last] @ wide.reshape(last - first, -1)
    done = _to_bytes(tall).reshape(height, 3, width)
    return np.ascontiguousarray(done.transpose(0, 2, 1))


def _weights(scale: float, source: int, target: Int64, kernel: Kernel) -> Float32:
    """Return (N, source): how much each pixel counts for the ``target`` pixels (N,).

    ``scale``: how many pixels of the source one of the result is wide.
    """
    widened = max(scale, 1.0)
    centre = (target + 0.5) * scale
    reach = SUPPORT[kernel] * widened
    low = np.maximum(0, np.floor(centre - reach + 0.5))[:, None]
    high = np.minimum(source, np.floor(centre + reach + 0.5))[:, None]
    pixel = np.arange(source)[None]
    weight = _KERNELS[kernel](np.abs(pixel + 0.5 - centre[:, None]) / widened)
    weight = np.where((pixel >= low) & (pixel < high), weight, 0.0)
    return np.asarray(weight / weight.sum(axis=1, keepdims=True), np.float32)


def _triangle(x: Float64) -> Float64:
    return np.maximum(0.0, 1.0 - x)


def _cubic(x: Float64) -> Float64:
    near = (1.5 * x - 2.5) * x * x + 1.0
    far = ((-0.5 * x + 2.5) * x - 4.0) * x + 2.0
    return np.where(x < 1, near, np.where(x < 2, far, 0.0))


_KERNELS = {"bilinear": _triangle, "bicubic": _cubic}


def _reach(rows: Float32) -> tuple[int, int]:
    """Return the source rows [first, last) that count for any target row."""
    used = np.flatnonzero(rows.any(axis=0))
    return int(used[0]), int(used[-1]) + 1


def _to_bytes(values: Float32) -> UInt8:
    return np.asarray(np.clip(np.floor(values + 0.5), 0, 255), np.uint8)
