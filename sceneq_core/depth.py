"""Depth images: the ray of every pixel, and depth with the noise of the sensor averaged out.

Depth is averaged as inverse depth, in which a plane is linear in the pixel: the mean over a window
is then the plane itself, which the mean of depth is not.
"""

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64

_NEAREST_M = 1e-3
_FARTHEST_PER_M = 1e-6
"""Bounds that only keep divisions defined; no sensor measures a millimetre or a thousand km."""


def pixel_rays(K: Float64, shape: tuple[int, ...], stride: int = 1) -> tuple[Float64, Float64]:
    """Return x / z of every kept column (w,) and y / z of every kept row (h,), float64.

    A pixel of depth z is the point (x z, y z, z) of the camera. ``shape`` begins with the full
    height and width; every ``stride``-th row and column is kept.
    """
    height, width = shape[:2]
    x = (np.arange(0, width, stride) - K[0, 2]) / K[0, 0]
    y = (np.arange(0, height, stride) - K[1, 2]) / K[1, 1]
    return x, y


def inverse_depth(depth_m: Float32, valid: Bool, radius_px: int) -> tuple[Float32, Float32]:
    """Return the inverse depth (H, W) and its mean over the window round each pixel, in 1/m.

    Only ``valid`` (H, W) pixels count; elsewhere the inverse depth is 0. The mean is 0 where the
    window of 2 ``radius_px`` + 1 pixels holds no valid one.
    """
    inverse = np.where(valid, 1.0 / np.maximum(depth_m, _NEAREST_M), 0.0).astype(np.float32)
    size = (2 * radius_px + 1, 2 * radius_px + 1)
    share = np.maximum(cv2.blur(valid.astype(np.float32), size), 1e-6)
    return inverse, (cv2.blur(inverse, size) / share).astype(np.float32)


def smoothed_depth(depth_m: Float32, mean_inverse: Float32, same_surface: float) -> Float64:
    """Return the depth of the window where it is one surface, else the measured depth, metres.

    ``mean_inverse`` is that of ``inverse_depth``. Depths that differ by less than ``same_surface``
    times the depth belong to one surface: over an edge the mean would lie between two.
    """
    z = depth_m.astype(np.float64)
    mean_m = 1.0 / np.maximum(mean_inverse, _FARTHEST_PER_M).astype(np.float64)
    return np.where(np.abs(mean_m - z) < same_surface * z, mean_m, z)
