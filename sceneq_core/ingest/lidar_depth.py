"""A LiDAR scan as the depth image of a camera beside it."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Array, Bool, Float32, Float64, Int64, UInt16
from sceneq_core.checks import need_at_least, need_between
from sceneq_core.ingest.source import Camera
from sceneq_core.ingest.transforms import transform

FAR = np.float32(np.inf)
NEAREST_M = 0.1
MAX_MM = 65534


@dataclass(frozen=True, slots=True)
class LidarDepthParams:
    """``reach_px`` pixels may lie between two measurements that are filled in.

    Between rings of the LiDAR that is their distance in the image. They are filled when both lie
    on one surface no steeper, against its normal, than ``max_slope_deg``: a road is. A measurement
    between two that are nearer by ``hidden_share`` of its depth is seen past them by the LiDAR but
    not by the camera.
    """

    reach_px: int = 8
    max_slope_deg: float = 86.0
    hidden_share: float = 0.15

    def __post_init__(self) -> None:
        need_at_least(self, 1, "reach_px")
        need_between(self, 0, 90, "max_slope_deg")
        need_between(self, 0, 1, "hidden_share")


def lidar_depth_mm(
    points_lidar: Float32,
    T_camera_lidar: Float64,
    camera: Camera,
    params: LidarDepthParams | None = None,
) -> UInt16:
    """Return uint16 (H, W) millimetres in ``camera`` of points (N, 3), 0 = nothing there.

    Farther than 65.5 m nothing can be said in 16 bits.
    """
    params = params or LidarDepthParams()
    depth_m = _nearest(points_lidar, T_camera_lidar, camera)
    depth_m[_hidden(depth_m, params)] = FAR
    slope = np.tan(np.deg2rad(params.max_slope_deg))
    # Down the image first: rings are far apart, points within a ring are close.
    for axis, focal_px in ((0, camera.K[1, 1]), (1, camera.K[0, 0])):
        depth_m = _filled(depth_m, axis, params.reach_px, float(slope / focal_px))
    depth_mm = np.rint(np.where(np.isfinite(depth_m), depth_m, 0) * np.float32(1000))
    return np.where(depth_mm <= MAX_MM, depth_mm, 0).astype(np.uint16)


def _nearest(points_lidar: Float32, T_camera_lidar: Float64, camera: Camera) -> Float32:
    """Return the nearest depth on every pixel, float32 (H, W), infinite where there is none."""
    x, y, z = transform(T_camera_lidar, points_lidar.astype(np.float64)).T
    ahead = z > NEAREST_M
    x, y, z = x[ahead], y[ahead], z[ahead]
    width, height = camera.size
    u = np.rint(camera.K[0, 0] * x / z + camera.K[0, 2])
    v = np.rint(camera.K[1, 1] * y / z + camera.K[1, 2])
    inside = (u >= 0) & (u < width) & (v >= 0) & (v < height)
    pixel = v[inside].astype(np.int64) * width + u[inside].astype(np.int64)
    depth_m = np.full(height * width, FAR)
    np.minimum.at(depth_m, pixel, z[inside].astype(np.float32))
    return depth_m.reshape(height, width)


def _hidden(depth_m: Float32, params: LidarDepthParams) -> Bool:
    """Tell which measurements have much nearer ones on two opposite sides."""
    reach = params.reach_px
    limit = depth_m * np.float32(1.0 - params.hidden_share)
    result = np.zeros(depth_m.shape, np.bool_)
    for shape in ((1, reach), (reach, 1)):
        before, after = _side_minimum(depth_m, shape, 1), _side_minimum(depth_m, shape, -1)
        result |= (before < limit) & (after < limit)
    return result & np.isfinite(depth_m)


def _side_minimum(depth_m: Float32, shape: tuple[int, int], side: int) -> Array:
    """Return the least depth of the pixels on one side, the pixel itself among them."""
    kernel = np.ones(shape, np.uint8)
    anchor = (0, 0) if side < 0 else (shape[1] - 1, shape[0] - 1)
    least: Array = cv2.erode(depth_m, kernel, anchor=anchor, borderValue=float(FAR))
    return least


def _filled(depth_m: Float32, axis: int, reach_px: int, slope_per_px: float) -> Float32:
    """Return the image with short gaps along ``axis`` filled where both ends are one surface.

    Along a plane the inverse depth is linear in the pixel.
    """
    image = depth_m if axis == 0 else depth_m.T
    before, after = _measured_rows(image)
    gap = after - before
    row, column = np.nonzero((gap > 1) & (gap <= reach_px + 1) & ~np.isfinite(image))
    above, below = before[row, column], after[row, column]
    a, b = image[above, column], image[below, column]
    apart = (below - above).astype(np.float32)
    joined = np.abs(a - b) <= slope_per_px * apart * np.minimum(a, b)
    row, column, above = row[joined], column[joined], above[joined]
    a, b = a[joined], b[joined]
    share = (row - above) / apart[joined]
    filled = image.copy()
    filled[row, column] = 1.0 / ((1.0 - share) / a + share / b)
    return filled if axis == 0 else np.ascontiguousarray(filled.T)


def _measured_rows(image: Float32) -> tuple[Int64, Int64]:
    """Return, per pixel, the last measured row at or above and the first at or below it.

    Where there is none, a row so far off that no gap is short.
    """
    height = len(image)
    rows = np.arange(height)[:, None]
    measured = np.isfinite(image)
    before = np.maximum.accumulate(np.where(measured, rows, -2 * height), axis=0)
    after = np.minimum.accumulate(np.where(measured, rows, 3 * height)[::-1], axis=0)[::-1]
    return before, after
