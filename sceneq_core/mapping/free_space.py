"""What the camera looks through is not there any more."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Float64, Int32
from sceneq_core.checks import need_at_least, need_positive, need_within
from sceneq_core.frame import Frame
from sceneq_core.mapping.cells import CELL_SIDE
from sceneq_core.mapping.rows import marked
from sceneq_core.mapping.voxels import Voxels

_NEAREST_M = 0.05
"""Closer to the camera than any sensor measures; the projection is not worth having there."""


@dataclass(frozen=True, slots=True)
class FreeSpaceParams:
    """When a voxel counts as seen through, and when as gone.

    The measured depth must lie behind the voxel by ``margin_m`` plus ``noise_per_m`` (1/m) times
    the squared depth (the noise of structured light and stereo grows so). A voxel is gone after
    ``min_views`` keyframes that see through it with none in between that sees it; voxels beyond
    ``max_depth_m`` are not tested.
    """

    margin_m: float = 0.06
    noise_per_m: float = 0.01
    min_views: int = 3
    max_depth_m: float = 5.0

    def __post_init__(self) -> None:
        need_positive(self, "margin_m", "max_depth_m")
        need_at_least(self, 0, "noise_per_m")
        need_within(self, 1, 255, "min_views")  # counted in uint8


def clear_free_space(
    voxels: Voxels, frame: Frame, touched_id: Int32, params: FreeSpaceParams
) -> Int32:
    """Empty the voxels that enough keyframes saw through; return their ids, sorted."""
    inside = voxels.cells.voxels(_cells_in_view(voxels, frame, params))
    seen_through = inside[_seen_through(voxels.centres_world(inside), frame, params)]
    seen_through = voxels.occupied(seen_through[~marked(touched_id, len(voxels))[seen_through]])
    voxels.misses[seen_through] += 1
    gone = np.sort(seen_through[voxels.misses[seen_through] >= params.min_views])
    voxels.clear(gone)
    return gone


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


def _seen_through(points_world: Float64, frame: Frame, params: FreeSpaceParams) -> Int32:
    """Return the rows of points whose pixel measures, with its neighbours, a surface far behind."""
    # The nearest depth around a pixel: at silhouettes and holes (0) nothing is called free.
    nearest_m = cv2.erode(frame.depth_m, np.ones((3, 3), np.uint8))
    points_camera = _to_camera(points_world, frame)
    z = points_camera[:, 2]
    index = np.flatnonzero((z > _NEAREST_M) & (z < params.max_depth_m))
    z = z[index]
    u = np.rint(points_camera[index, 0] / z * frame.K[0, 0] + frame.K[0, 2])
    v = np.rint(points_camera[index, 1] / z * frame.K[1, 1] + frame.K[1, 2])
    height, width = nearest_m.shape
    inside = (u >= 0) & (u < width) & (v >= 0) & (v < height)
    index, z = index[inside], z[inside]
    measured_m = nearest_m[v[inside].astype(np.intp), u[inside].astype(np.intp)]
    through = measured_m > z + params.margin_m + params.noise_per_m * z * z
    seen: Int32 = index[through].astype(np.int32)
    return seen
