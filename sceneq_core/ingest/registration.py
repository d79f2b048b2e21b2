"""Depth as the colour camera would have measured it."""

import math
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64, Int32, UInt16
from sceneq_core.ingest.source import Camera

NOTHING = np.uint16(65535)
"""Farther than every measurement, so that a nearest-wins buffer can start with it."""


@dataclass(frozen=True, slots=True)
class RegistrationParams:
    """``max_slope_deg``: the steepest surface, seen against its normal, whose cracks are closed.

    Beyond it a jump in depth counts as the edge of an object, and nothing is filled across.
    """

    max_slope_deg: float = 80.0

    def __post_init__(self) -> None:
        if not 0 <= self.max_slope_deg < 90:
            raise ValueError(f"max_slope_deg: expected 0 to below 90, got {self.max_slope_deg}")


class DepthRegistration:
    """Warps depth images into the colour camera; the identity when both are one camera."""

    def __init__(
        self,
        depth_camera: Camera,
        color_camera: Camera,
        T_color_depth: Float64,
        params: RegistrationParams | None = None,
    ) -> None:
        params = params or RegistrationParams()
        self.is_identity = _is_one_camera(depth_camera, color_camera, T_color_depth)
        self._size = color_camera.size
        self._warp = _Warp(depth_camera, color_camera, T_color_depth)
        # Two pixels apart, on a plane of that slope, depth differs by this share of itself.
        self._same_surface = 2 * math.tan(math.radians(params.max_slope_deg)) / color_camera.K[0, 0]

    def register(self, depth_mm: UInt16) -> UInt16:
        """Return uint16 (H, W) millimetres in the colour camera, 0 = no measurement."""
        if self.is_identity:
            return depth_mm
        width, height = self._size
        nearest = np.full(height * width, NOTHING)
        for index, mm in self._warp.splats(depth_mm):
            np.minimum.at(nearest, index, mm)
        nearest[nearest == NOTHING] = 0
        return _close_cracks(nearest.reshape(height, width), self._same_surface)


class _Warp:
    """Where depth pixels land in the colour image.

    With the ray r = R K_depth^-1 (u, v, 1) and K the colour camera's, a depth z lands at
    K (z r + t): linear in z, so per pixel only ``a`` = K r and once ``b`` = K t are needed.
    """

    def __init__(self, depth: Camera, color: Camera, T_color_depth: Float64) -> None:
        width, height = depth.size
        u, v = np.meshgrid(np.arange(width), np.arange(height))
        pixels = np.stack([u, v, np.ones_like(u)]).reshape(3, -1)
        a = color.K @ T_color_depth[:3, :3] @ np.linalg.inv(depth.K) @ pixels
        self._a: Float32 = a.astype(np.float32)
        self._b: Float32 = (color.K @ T_color_depth[:3, 3] * 1000.0).astype(np.float32)
        self._size = color.size
        self._footprint = _footprint_px(depth, color)

    def splats(self, depth_mm: UInt16) -> list[tuple[Int32, UInt16]]:
        """Return flat colour pixel indices and millimetres there, one pair per splat pixel."""
        measured = np.flatnonzero(depth_mm)
        z = depth_mm.reshape(-1)[measured].astype(np.float32)
        x, y, depth = (a[measured] * z + b for a, b in zip(self._a, self._b, strict=True))
        ahead = (depth >= 0.5) & (depth < float(NOTHING) - 0.5)
        x, y, depth = x[ahead], y[ahead], depth[ahead]
        mm = np.rint(depth).astype(np.uint16)
        left, top = self._first_pixel(x / depth), self._first_pixel(y / depth)
        n = self._footprint
        return [self._inside(left + i, top + j, mm) for j in range(n) for i in range(n)]

    def _first_pixel(self, at: Float32) -> Float32:
        first: Float32 = np.ceil(at - np.float32(self._footprint / 2))
        return first

    def _inside(self, x: Float32, y: Float32, mm: UInt16) -> tuple[Int32, UInt16]:
        width, height = self._size
        inside: Bool = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        index = y[inside].astype(np.int32) * width + x[inside].astype(np.int32)
        return index, mm[inside]


def _footprint_px(depth: Camera, color: Camera) -> int:
    """Return how many colour pixels wide a depth pixel is, rounded up."""
    scale = max(float(color.K[i, i] / depth.K[i, i]) for i in (0, 1))
    return max(1, math.ceil(scale - 1e-6))


def _close_cracks(depth_mm: UInt16, same_surface: float) -> UInt16:
    """Fill pixels without depth whose two neighbours in a row or column lie on one surface."""
    filled = depth_mm.copy()
    y, x = np.nonzero(depth_mm[1:-1, 1:-1] == 0)
    y, x = y + 1, x + 1
    for dy, dx in ((1, 0), (0, 1)):
        a = depth_mm[y - dy, x - dx].astype(np.int32)
        b = depth_mm[y + dy, x + dx].astype(np.int32)
        low = np.minimum(a, b)
        joined = (low > 0) & (np.abs(a - b) <= same_surface * low)
        filled[y[joined], x[joined]] = ((a + b) // 2)[joined]
    return filled


def _is_one_camera(depth: Camera, color: Camera, T_color_depth: Float64) -> bool:
    return (
        depth.size == color.size
        and np.array_equal(depth.K, color.K)
        and np.array_equal(T_color_depth, np.eye(4))
    )
