"""Points as a picture without holes: squares with a depth buffer, closed, shaded, outlined."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64, Int32, Int64, UInt8, UInt16
from sceneq_core.picture.projection import Viewpoint

BACKGROUND = (252, 252, 250)
FINER = 2
"""Drawn with this many times the pixels and averaged: smooth edges."""
OVERLAP = 1.35
"""A splat is that much wider than a voxel: the next one may be a diagonal away."""
MAX_SIDE = 25
CLOSED_VOXELS = 3.0
"""Gaps of that many voxels are closed: surfaces seen at a grazing angle are sparse."""
EDGE_REACHES = (2, 6)
EDGE_STEP_M = 0.3
EDGE_DARK = 1.6
FAR_M = 1e3
NOTHING = -1


@dataclass(frozen=True, slots=True)
class Splats:
    """What is seen where: the point (H, W) nearest to the camera, -1 = none, and its depth.

    Attributes:
        point: index into the points, int64 (H, W).
        depth_m: float32 (H, W), infinite where there is none.
    """

    point: Int64
    depth_m: Float32


def splat(viewpoint: Viewpoint, points_world: Float64, point_m: float) -> Splats:
    """Return which of the points (N, 3), squares of ``point_m`` metres, is seen in each pixel."""
    width, height = viewpoint.size
    pixels, depth_m = viewpoint.project(points_world)
    near_last = np.argsort(-depth_m, kind="stable")
    near_last = near_last[depth_m[near_last] > 0.05]
    depth_m = depth_m[near_last]
    side = _side(viewpoint, depth_m, point_m)
    buffer = Splats(
        np.full((height, width), NOTHING, np.int64), np.full((height, width), np.inf, np.float32)
    )
    left, top = np.rint(pixels[near_last].T - (side - 1) / 2).astype(np.int64)
    for dv, du in np.ndindex(int(side.max(initial=0)), int(side.max(initial=0))):
        u, v = left + du, top + dv
        inside = (side > max(dv, du)) & (u >= 0) & (v >= 0) & (u < width) & (v < height)
        drawn = np.flatnonzero(inside)
        pixel = v.take(drawn) * width + u.take(drawn)
        _write(buffer, pixel, near_last.take(drawn), depth_m.take(drawn))
    return _closed(buffer, viewpoint, point_m)


def shaded(splats: Splats, rgb: UInt8, instance_id: Int32) -> UInt8:
    """Return the picture (H, W, 3): each point's colour, darker behind edges and along outlines."""
    empty = splats.point == NOTHING
    image = rgb[splats.point].astype(np.float32)
    image *= _eye_dome(splats.depth_m)[..., None]
    image *= np.where(_outline(_numbers_seen(splats, instance_id)), 0.55, 1.0)[..., None]
    image[empty] = BACKGROUND
    out: UInt8 = image.astype(np.uint8)
    return out


def ids_seen(splats: Splats, instance_id: Int32) -> Int32:
    """Return the instance (H, W) seen in each pixel, -1 = background, 0 = no instance."""
    ids = instance_id[splats.point]
    ids[splats.point == NOTHING] = -1
    return ids


def reduced(image: UInt8, factor: int = FINER) -> UInt8:
    """Return an image (H, W, 3) with ``factor`` times fewer pixels a side."""
    size = (image.shape[1] // factor, image.shape[0] // factor)
    out: UInt8 = cv2.resize(image, size, interpolation=cv2.INTER_AREA).astype(np.uint8)
    return out


def _side(viewpoint: Viewpoint, depth_m: Float64, point_m: float) -> Int64:
    side = np.ceil(OVERLAP * point_m * viewpoint.pixels_per_metre(depth_m))
    whole: Int64 = np.clip(side, 1, MAX_SIDE).astype(np.int64)
    return whole


def _write(buffer: Splats, pixel: Int64, point: Int64, depth_m: Float64) -> None:
    """Write points ordered far to near: of several on one pixel the last, nearest, stays."""
    point_at, depth_at = buffer.point.reshape(-1), buffer.depth_m.reshape(-1)
    nearer = np.flatnonzero(depth_m < depth_at.take(pixel))
    pixel = pixel.take(nearer)
    point_at[pixel] = point.take(nearer)
    depth_at[pixel] = depth_m.take(nearer)


def _closed(buffer: Splats, viewpoint: Viewpoint, point_m: float) -> Splats:
    """Give pixels in narrow gaps to the nearest point drawn."""
    drawn = buffer.point != NOTHING
    if not drawn.any():
        return buffer
    scale = viewpoint.pixels_per_metre(np.median(buffer.depth_m[drawn]).astype(np.float64)[None])
    reach = min(MAX_SIDE, max(1, round(CLOSED_VOXELS * point_m * float(scale[0]) / 2)))
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    gaps = cv2.morphologyEx(drawn.astype(np.uint8), cv2.MORPH_CLOSE, kernel).astype(bool) & ~drawn
    v, u = _nearest_drawn(drawn, gaps)
    buffer.point[gaps] = buffer.point[v, u]
    buffer.depth_m[gaps] = buffer.depth_m[v, u]
    return buffer


def _nearest_drawn(drawn: Bool, gaps: Bool) -> tuple[Int64, Int64]:
    """Return row and column of the drawn pixel nearest to each gap pixel."""
    _, label = cv2.distanceTransformWithLabels(
        (~drawn).astype(np.uint8), cv2.DIST_L2, 3, labelType=cv2.DIST_LABEL_PIXEL
    )
    v, u = np.nonzero(drawn)
    of_label = np.zeros(int(label.max()) + 1, np.int64)
    of_label[label[v, u]] = np.arange(len(v))
    chosen = of_label[label[gaps]]
    return v[chosen], u[chosen]


def _eye_dome(depth_m: Float32) -> Float32:
    """Return a brightness (H, W), less where neighbours are nearer (after Boucheny 2009).

    Steps count in metres, not in logarithms of the distance: a plan has no distance.
    """
    far = np.where(np.isfinite(depth_m), depth_m, FAR_M).astype(np.float32)
    shade = np.zeros_like(far)
    for reach in EDGE_REACHES:
        for shift, axis in ((reach, 0), (-reach, 0), (reach, 1), (-reach, 1)):
            step_m = far - np.roll(far, shift, axis)
            shade += np.clip(step_m / EDGE_STEP_M - 0.1, 0, 1)
    brightness: Float32 = np.exp(-EDGE_DARK * shade / (4 * len(EDGE_REACHES)))
    return brightness


def _numbers_seen(splats: Splats, instance_id: Int32) -> UInt16:
    """Return the instances (H, W) seen, numbered from 1 in the order of their ids, 0 = background.

    The points are numbered, not the pixels: of those there are many more.
    """
    _, number = np.unique(instance_id, return_inverse=True)
    seen = (number.ravel() + 1).astype(np.uint16)[splats.point]
    seen[splats.point == NOTHING] = 0
    return seen


def _outline(number: UInt16) -> Bool:
    """Tell which pixels (H, W) have another instance to their right or below; specks do not count.

    The median filter takes 16 bits: hence numbers, not ids.
    """
    calm = cv2.medianBlur(cv2.medianBlur(number, 5), 5).astype(np.int32)
    edge = np.zeros(calm.shape, np.bool_)
    edge[:, :-1] |= calm[:, :-1] != calm[:, 1:]
    edge[:-1] |= calm[:-1] != calm[1:]
    return edge
