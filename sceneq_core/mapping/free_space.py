"""Which voxels the camera looks through."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Float32, Float64, Int32, Int64
from sceneq_core.checks import need_at_least, need_positive
from sceneq_core.frame import Frame
from sceneq_core.mapping.cells import CELL_SIDE, SLOT_COORD
from sceneq_core.mapping.rows import marked
from sceneq_core.mapping.voxels import Voxels

_NEAREST_M = 0.05
"""Closer to the camera than any sensor measures; the projection is not worth having there."""


@dataclass(frozen=True, slots=True)
class FreeSpaceParams:
    """When a voxel counts as seen through.

    The measured depth must lie behind the voxel by ``margin_m`` plus ``noise_per_m`` (1/m) times
    the squared depth (the noise of structured light and stereo grows so); voxels beyond
    ``max_depth_m`` are not tested.
    """

    margin_m: float = 0.04
    noise_per_m: float = 0.008
    max_depth_m: float = 5.0

    def __post_init__(self) -> None:
        need_positive(self, "margin_m", "max_depth_m")
        need_at_least(self, 0, "noise_per_m")


def find_seen_through(
    voxels: Voxels, touched_id: Int32, frame: Frame, params: FreeSpaceParams
) -> Int32:
    """Return the occupied voxels, not touched, with a measured surface far behind them."""
    # The nearest depth around a pixel: at silhouettes and holes (0) nothing is called free.
    nearest_m = np.asarray(cv2.erode(frame.depth_m, np.ones((3, 3), np.uint8)), np.float32)
    cell_id = _cells_in_view(voxels, frame, params)
    inside, row, slot = voxels.cells.contents(cell_id)
    kept = np.flatnonzero(~marked(touched_id, len(voxels)).take(inside))
    inside, row, slot = inside.take(kept), row.take(kept), slot.take(kept)
    # A centre is its cell's corner plus its slot's offset: two small products, no large one.
    size = voxels.voxel_size_m
    corner_world = voxels.cells.origins(cell_id).astype(np.float64) * size
    corner = _to_camera(corner_world, frame).astype(np.float32)
    offset = ((SLOT_COORD + 0.5) * size @ frame.T_world_camera[:3, :3]).astype(np.float32)
    x, y, z = (c.take(row) + o.take(slot) for c, o in zip(corner.T, offset.T, strict=True))
    return voxels.occupied(inside.take(_free(x, y, z, nearest_m, frame, params)))


def _to_camera(points_world: Float64, frame: Frame) -> Float64:
    rotation, translation = frame.T_world_camera[:3, :3], frame.T_world_camera[:3, 3]
    points_camera: Float64 = points_world @ rotation - translation @ rotation
    return points_camera


def _cells_in_view(voxels: Voxels, frame: Frame, params: FreeSpaceParams) -> Int32:
    """Return the cells whose bounding sphere reaches into the camera's cone and range."""
    radius = CELL_SIDE * voxels.voxel_size_m * np.sqrt(3.0) / 2.0
    centre = _to_camera(voxels.cells.centres_world(voxels.voxel_size_m), frame)
    height, width = frame.depth_m.shape
    z = centre[:, 2]
    near = np.maximum(z, 0.0)
    visible = (z > -radius) & (z < params.max_depth_m + radius)
    for axis, length in ((0, width), (1, height)):
        f, c = frame.K[axis, axis], frame.K[axis, 2]
        # The margin in metres over the tangent plane of the image edge, exact for a sphere.
        low, high = c / f, (length - c) / f
        visible &= centre[:, axis] > -near * low - radius * np.hypot(1.0, low)
        visible &= centre[:, axis] < near * high + radius * np.hypot(1.0, high)
    return np.flatnonzero(visible).astype(np.int32)


def _free(
    x: Float32,
    y: Float32,
    z: Float32,
    nearest_m: Float32,
    frame: Frame,
    params: FreeSpaceParams,
) -> Int64:
    """Return the rows of camera points whose pixel, with its neighbours, measures far behind."""
    row = np.flatnonzero((z > _NEAREST_M) & (z < params.max_depth_m))
    z = z.take(row)
    K = frame.K.astype(np.float32)
    u = np.floor(x.take(row) / z * K[0, 0] + (K[0, 2] + np.float32(0.5))).astype(np.int32)
    v = np.floor(y.take(row) / z * K[1, 1] + (K[1, 2] + np.float32(0.5))).astype(np.int32)
    height, width = nearest_m.shape
    inside = np.flatnonzero((u >= 0) & (u < width) & (v >= 0) & (v < height))
    row, z = row.take(inside), z.take(inside)
    measured_m = nearest_m.reshape(-1).take(v.take(inside) * width + u.take(inside))
    free: Int64 = row[measured_m > z + (params.margin_m + params.noise_per_m * z * z)]
    return free
