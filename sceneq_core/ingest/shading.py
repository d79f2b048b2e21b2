"""How bright surfaces are, compared with what is around them."""

from collections.abc import Callable

import cv2
import numpy as np

from sceneq_core.arrays import Float32, Float64, UInt8
from sceneq_core.ingest.source import Camera
from sceneq_core.ingest.transforms import transform

Shading = Callable[[Float64], Float32]
"""Returns the shade float32 (N,) of points (N, 3) in the depth camera, NaN where none is seen."""

WIDTH_PX = 320
"""The picture is made that wide first: finer detail than the depth grid's would only be noise."""
DETAIL_PX = 5
SURROUNDINGS_PX = 41
MIN_CONTRAST = 2.0
"""Below that deviation, in steps of 8-bit brightness, a surface is plain: it looks like any."""
MIN_POINTS = 100


def shading(rgb: UInt8, camera: Camera, T_color_depth: Float64) -> Shading:
    """Return the shading by a picture uint8 (H, W, 3) of the colour camera.

    Brightness minus its mean nearby: it stays the same when the exposure changes.
    """
    scale = WIDTH_PX / rgb.shape[1]
    size = (WIDTH_PX, max(1, round(rgb.shape[0] * scale)))
    grey = cv2.resize(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), size, interpolation=cv2.INTER_AREA)
    detail = cv2.GaussianBlur(grey, (DETAIL_PX, DETAIL_PX), 0).astype(np.float32)
    shade = detail - cv2.blur(detail, (SURROUNDINGS_PX, SURROUNDINGS_PX))

    def of(points: Float64) -> Float32:
        x, y, z = transform(T_color_depth, points).T
        z = np.where(z > 0, z, np.nan)
        column = (x / z * camera.K[0, 0] + camera.K[0, 2]) * scale
        row = (y / z * camera.K[1, 1] + camera.K[1, 2]) * scale
        found = cv2.remap(
            shade,
            column.astype(np.float32).reshape(-1, 1),
            row.astype(np.float32).reshape(-1, 1),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=float("nan"),
        )
        return found.reshape(-1).astype(np.float32)

    return of


def likeness(one: Float32, other: Float32) -> float:
    """Return the correlation of two shades (N,) of the same points; NaN = too plain to tell."""
    known = np.isfinite(one) & np.isfinite(other)
    if known.sum() < MIN_POINTS:
        return float("nan")
    a, b = (shade[known].astype(np.float64) for shade in (one, other))
    a, b = a - a.mean(), b - b.mean()
    contrast = np.sqrt((a * a).mean()), np.sqrt((b * b).mean())
    if min(contrast) < MIN_CONTRAST:
        return float("nan")
    return float((a * b).mean() / (contrast[0] * contrast[1]))
