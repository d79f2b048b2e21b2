"""A depth image as a small pyramid of oriented points."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64, Int32, UInt16
from sceneq_core.checks import need_at_least, need_positive
from sceneq_core.depth import pixel_rays
from sceneq_core.ingest.shading import Shading

NO_SHADE = np.zeros(0, np.float32)
MEDIAN_PX = 5
"""Window of the median that takes out single wrong depths before the image is thinned."""


@dataclass(frozen=True, slots=True)
class DepthViewParams:
    """How much of a depth image is used.

    ``columns``: points in a row of the finest level; ``levels``, each half as fine as the one
    before; ``max_range_m``: farther depth is noise; ``max_slope``: neighbouring depths that differ
    by more than this share of themselves lie on different surfaces.
    """

    columns: int = 160
    levels: int = 3
    max_range_m: float = 6.0
    max_slope: float = 0.08

    def __post_init__(self) -> None:
        need_at_least(self, 8, "columns")
        need_at_least(self, 1, "levels")
        need_positive(self, "max_range_m", "max_slope")


@dataclass(frozen=True, slots=True)
class Level:
    """Oriented points of the depth camera in a grid of ``shape`` (h, w).

    ``points`` and unit ``normals``, which face the camera, float64 (N, 3); ``row`` int32 (h, w) is
    theirs at each pixel, -1 = none. ``f`` and ``c`` (2,) project a point to (column, row).
    """

    points: Float64
    normals: Float64
    row: Int32
    f: Float64
    c: Float64


@dataclass(frozen=True, slots=True)
class DepthView:
    """``levels`` from coarse to fine of one depth image.

    ``shade`` float32 (N,) of the points of the finest one, empty when there is no picture.
    """

    levels: tuple[Level, ...]
    shade: Float32

    @property
    def coarse(self) -> "DepthView":
        """The coarsest level alone."""
        return DepthView(self.levels[:1], NO_SHADE)

    def shaded(self, shading: Shading | None) -> "DepthView":
        """Return the view with the shade of a picture taken at the same time."""
        return self if shading is None else replace(self, shade=shading(self.levels[-1].points))

    @property
    def count(self) -> int:
        """Number of points of the finest level."""
        return len(self.levels[-1].points)


def thin_depth(depth_mm: UInt16, K: Float64, params: DepthViewParams) -> tuple[UInt16, Float64]:
    """Return the finest level's depth, uint16 millimetres, and its intrinsics (3, 3)."""
    stride = max(1, round(depth_mm.shape[1] / params.columns))
    far = np.uint16(min(params.max_range_m * 1000.0, 65535.0))
    near_mm = np.where(depth_mm > far, np.uint16(0), depth_mm)
    thin = cv2.medianBlur(near_mm, MEDIAN_PX)[::stride, ::stride].astype(np.uint16)
    return thin, _strided(K, stride)


def depth_view(thin_mm: UInt16, K: Float64, params: DepthViewParams) -> DepthView:
    """Return the pyramid of a thinned depth image (see ``thin_depth``)."""
    levels = []
    for i in range(params.levels):
        step = 2**i
        depth_m = thin_mm[::step, ::step].astype(np.float64) * 1e-3
        levels.append(_level(depth_m, _strided(K, step), params.max_slope * step**0.5))
    return DepthView(tuple(reversed(levels)), NO_SHADE)


def _level(depth_m: Float64, K: Float64, max_slope: float) -> Level:
    x, y = pixel_rays(K, depth_m.shape, 1)
    points = np.stack([x[None] * depth_m, y[:, None] * depth_m, depth_m], axis=-1)
    normals, valid = _normals(points, max_slope)
    row = np.full(valid.shape, -1, np.int32)
    row[valid] = np.arange(int(valid.sum()), dtype=np.int32)
    return Level(points[valid], normals[valid], row, np.diag(K)[:2].copy(), K[:2, 2].copy())


def _normals(points: Float64, max_slope: float) -> tuple[Float64, Bool]:
    """Return normals (h, w, 3) from the four neighbours, and where those are one surface."""
    z = points[1:-1, 1:-1, 2]
    across = points[1:-1, 2:] - points[1:-1, :-2]
    down = points[2:, 1:-1] - points[:-2, 1:-1]
    nx = down[..., 1] * across[..., 2] - down[..., 2] * across[..., 1]
    ny = down[..., 2] * across[..., 0] - down[..., 0] * across[..., 2]
    nz = down[..., 0] * across[..., 1] - down[..., 1] * across[..., 0]
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    steepest = np.maximum(np.abs(across[..., 2]), np.abs(down[..., 2]))
    smooth = (z > 0) & (length > 0) & (steepest < 2 * max_slope * z)
    for neighbour in (points[1:-1, 2:], points[1:-1, :-2], points[2:, 1:-1], points[:-2, 1:-1]):
        smooth &= neighbour[..., 2] > 0
    normals, valid = np.zeros_like(points), np.zeros(points.shape[:2], np.bool_)
    inner = np.stack((nx, ny, nz), axis=-1) / np.maximum(length, 1e-12)[..., None]
    normals[1:-1, 1:-1], valid[1:-1, 1:-1] = inner, smooth
    return normals, valid


def _strided(K: Float64, stride: int) -> Float64:
    """Return the intrinsics of an image of which every ``stride``-th pixel is kept."""
    thinned = K.copy()
    thinned[:2] /= stride
    return thinned
