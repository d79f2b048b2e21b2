"""The surface that one frame measures: points with normals, colours and weights."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64, Int32, UInt8
from sceneq_core.checks import need_at_least, need_between, need_positive
from sceneq_core.depth import inverse_depth, pixel_rays, smoothed_depth
from sceneq_core.frame import Frame
from sceneq_core.vectors import unit_rows


@dataclass(frozen=True, slots=True)
class SurfaceParams:
    """Which pixels become surface points.

    ``stride_px`` keeps every n-th row and column; ``min_depth_m`` and ``max_depth_m`` bound the
    range of the sensor; ``normal_radius_px`` is the half window of the plane fit behind a normal,
    in kept pixels; ``max_jump_per_m`` is the relative depth step to a neighbour from which a
    pixel counts as mixed foreground and background; ``min_cosine`` refuses grazing views. A depth
    is replaced by the mean of its window when they differ by less than ``max_smooth_per_m``.
    """

    stride_px: int = 2
    min_depth_m: float = 0.2
    max_depth_m: float = 6.0
    normal_radius_px: int = 2
    max_jump_per_m: float = 0.05
    max_smooth_per_m: float = 0.02
    min_cosine: float = 0.12

    def __post_init__(self) -> None:
        need_at_least(self, 1, "stride_px", "normal_radius_px")
        need_positive(self, "min_depth_m", "max_jump_per_m")
        need_at_least(self, 0, "max_smooth_per_m")
        need_between(self, 0, 1, "min_cosine")
        if not self.max_depth_m > self.min_depth_m:
            raise ValueError(f"max_depth_m: must exceed min_depth_m, got {self.max_depth_m}")


@dataclass(frozen=True, slots=True)
class SurfacePoints:
    """N parallel rows: ``points_world`` and ``normals_world`` float64 (N, 3), ``rgb`` uint8 (N, 3).

    ``weight`` float64 (N,) is the relative trust in a point; ``row`` and ``column`` int32 (N,) are
    the full-resolution pixel that measured it. Normals point towards the camera.
    """

    points_world: Float64
    normals_world: Float64
    rgb: UInt8
    weight: Float64
    row: Int32
    column: Int32


def measure_surface(frame: Frame, params: SurfaceParams) -> SurfacePoints:
    """Back-project ``frame`` and leave out flying pixels, grazing views and far measurements."""
    stride = params.stride_px
    depth_m = np.ascontiguousarray(frame.depth_m[::stride, ::stride])
    x, y = pixel_rays(frame.K, frame.depth_m.shape, stride)
    valid = (depth_m > params.min_depth_m) & (depth_m < params.max_depth_m)
    inverse, mean = inverse_depth(depth_m, valid, params.normal_radius_px)
    filled = np.where(valid, inverse, mean)
    step = (stride / frame.K[0, 0], stride / frame.K[1, 1])
    normal, cosine = _normals(filled, mean, x, y, step, params.normal_radius_px)
    keep = valid & (cosine > params.min_cosine) & ~_mixed(depth_m, params.max_jump_per_m)
    index = np.flatnonzero(keep)
    row, column = (i.astype(np.int32) for i in np.divmod(index, len(x)))
    z = smoothed_depth(depth_m.take(index), mean.take(index), params.max_smooth_per_m)
    points_camera = np.stack((x.take(column) * z, y.take(row) * z, z), axis=1)
    rotation, translation = frame.T_world_camera[:3, :3], frame.T_world_camera[:3, 3]
    normals_camera = np.stack([n.take(index) for n in normal], axis=1, dtype=np.float64)
    points_world = points_camera @ rotation.T
    for axis in range(3):  # quicker than to add rows
        points_world[:, axis] += translation[axis]
    return SurfacePoints(
        points_world=points_world,
        normals_world=unit_rows(normals_camera @ rotation.T),
        rgb=frame.rgb[::stride, ::stride].reshape(-1, 3).take(index, axis=0),
        weight=cosine.take(index) / (z * z),
        row=row * stride,
        column=column * stride,
    )


def _mixed(depth_m: Float32, max_jump_per_m: float) -> Bool:
    """Tell which pixels lie on a depth edge, where sensors interpolate between two surfaces."""
    kernel = np.ones((3, 3), np.uint8)
    nearest = cv2.erode(np.where(depth_m > 0, depth_m, np.float32(np.inf)), kernel)
    farthest = cv2.dilate(depth_m, kernel)
    return np.asarray(farthest - nearest > max_jump_per_m * depth_m)


def _normals(
    filled: Float32, mean: Float32, x: Float64, y: Float64, step: tuple[float, float], radius: int
) -> tuple[list[Float32], Float32]:
    """Return x, y, z (H, W) of normals towards the camera and their cosine to the viewing ray.

    The inverse depth of a plane is linear in the pixel, so its least-squares slope in a window is
    the normal up to scale, which is not taken out. ``step`` is the distance between pixels in
    ``x`` and in ``y``.
    """
    ramp = np.arange(-radius, radius + 1, dtype=np.float32)
    ramp /= (ramp**2).sum()
    box = np.full(2 * radius + 1, 1.0 / (2 * radius + 1), np.float32)
    slope_x = cv2.sepFilter2D(filled, -1, ramp / np.float32(-step[0]), box)
    slope_y = cv2.sepFilter2D(filled, -1, box, ramp / np.float32(-step[1]))
    x32, y32 = x.astype(np.float32)[None, :], y.astype(np.float32)[:, None]
    slope_z = -mean - x32 * slope_x - y32 * slope_y
    length = np.sqrt(slope_x * slope_x + slope_y * slope_y + slope_z * slope_z)
    length *= np.sqrt(1.0 + x32 * x32 + y32 * y32)
    return [slope_x, slope_y, slope_z], mean / np.maximum(length, np.float32(1e-9))
