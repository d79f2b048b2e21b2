"""Which voxel every pixel of a keyframe shows: visibility that is depth-tested by construction.

A *place* is a voxel coordinate the map has used. Places are numbered for ever, unlike voxel ids,
which start again when the writer of the map does; so what a keyframe shows stays true while
voxels, superpoints and instances change around it.
"""

import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64, Int32, Int64
from sceneq_core.depth import inverse_depth, pixel_rays, smoothed_depth
from sceneq_core.frame import Frame
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.mapping.rows import with_rows
from sceneq_core.mapping.voxel_index import COORD_LIMIT, VoxelIndex

STRIDE_PX = 2
NO_PLACE = -1
WINDOW_RADIUS_PX = 2
SAME_SURFACE = 0.02
"""Window and tolerance of the smoothing of depth, those with which the map is made by default."""


class Places:
    """Numbers the places of a map and finds those that a frame shows."""

    def __init__(self) -> None:
        self._index = VoxelIndex()
        self._place_of_voxel = np.zeros(0, np.int32)

    def __len__(self) -> int:
        return len(self._index)

    def coords(self, first: int) -> Int32:
        """Return the grid coordinates (N, 3) of the places from ``first`` on."""
        return self._index.coords(first)

    def extend(self, coord: Int32) -> None:
        """Number further places, at grid coordinates (N, 3), as another ``Places`` did."""
        self._index.extend(coord)

    def forget_voxels(self) -> None:
        """Start again with voxel ids; places keep their numbers."""
        self._place_of_voxel = np.zeros(0, np.int32)

    def of(self, voxel_id: Int32) -> Int32:
        """Return the places (M,) of voxel ids (M,), -1 for one that is not known."""
        known = (voxel_id >= 0) & (voxel_id < len(self._place_of_voxel))
        place = np.full(len(voxel_id), NO_PLACE, np.int32)
        place[known] = self._place_of_voxel[voxel_id[known]]
        return place

    def moves(self, from_place: Int32, to_place: Int32) -> Int32:
        """Return where the surface at each place is now, int32 (P + 1,); the last one is -1."""
        now = np.append(np.arange(len(self), dtype=np.int32), np.int32(NO_PLACE))
        known = (from_place >= 0) & (to_place >= 0)
        now[from_place[known]] = to_place[known]
        return now

    def learn(self, voxel_id: Int32, voxel_coord: Int32) -> None:
        """Take over that voxel ids (M,) lie at grid coordinates (M, 3)."""
        count = int(voxel_id.max(initial=-1)) + 1
        self._place_of_voxel = with_rows(self._place_of_voxel, count, NO_PLACE)
        new = self._place_of_voxel[voxel_id] == NO_PLACE
        self._place_of_voxel[voxel_id[new]] = self._index.insert(voxel_coord[new])

    def instance_of_place(self, replica: MapReplica) -> Int32:
        """Return the instance at each place, int32 (P + 1,); the last one, for -1, is 0."""
        instance_id = np.zeros(len(self) + 1, np.int32)
        place = self._place_of_voxel[: replica.voxel_count]
        instance_id[place] = replica.instance_of_voxel()
        instance_id[NO_PLACE] = 0
        return instance_id

    def render(self, frame: Frame, voxel_size_m: float) -> Int32:
        """Return the place that each pixel of every second row and column shows, -1 = none.

        int32 (ceil(H / 2), ceil(W / 2)). Raises ``ValueError`` when there is no map yet.
        """
        if not voxel_size_m > 0:
            raise ValueError(f"frame {frame.seq}: no map to look at yet")
        points_voxel, measured = _points_in_voxels(frame, voxel_size_m)
        coord = np.floor(points_voxel).astype(np.int32)
        first, of_pixel = _runs(coord)
        place = np.full(measured.shape, NO_PLACE, np.int32)
        nearest = self._nearest(coord.take(first, 1).T, points_voxel.take(first, 1).T)
        place[measured] = nearest.take(of_pixel)
        return place

    def _nearest(self, coord: Int32, points_voxel: Float64) -> Int32:
        """Return the place at each coordinate (M, 3) or, where there is none, at the closest face.

        The map leaves out depth edges and grazing views; half a voxel away is the same surface.
        """
        place = self._index.lookup(coord)
        missing = np.flatnonzero(place < 0)
        offset = points_voxel[missing] - coord[missing] - 0.5
        row, axis = np.arange(len(missing)), np.argmax(np.abs(offset), axis=1)
        beside = coord[missing]
        beside[row, axis] += np.where(offset[row, axis] < 0, -1, 1).astype(np.int32)
        place[missing] = self._index.lookup(beside)
        return place


def _points_in_voxels(frame: Frame, voxel_size_m: float) -> tuple[Float64, Bool]:
    """Return the measured points (3, M) in voxel units of the world and their pixels (H/2, W/2).

    Points that are too far from the origin to have a voxel count as not measured.
    """
    depth_m = _depth_of_map(np.ascontiguousarray(frame.depth_m[::STRIDE_PX, ::STRIDE_PX]))
    farthest_m = (COORD_LIMIT - 2) * voxel_size_m - np.abs(frame.T_world_camera[:3, 3]).max()
    measured = (depth_m > 0) & (depth_m * _longest_ray(frame) < farthest_m)
    row, column = np.nonzero(measured)
    ray_x, ray_y = pixel_rays(frame.K, frame.depth_m.shape, STRIDE_PX)
    z = depth_m[measured]
    x, y = ray_x[column] * z, ray_y[row] * z
    T_voxel_camera = frame.T_world_camera / voxel_size_m
    # Written out: a matrix product may round otherwise with another number of threads.
    return np.stack([a * x + b * y + c * z + t for a, b, c, t in T_voxel_camera[:3]]), measured


def _longest_ray(frame: Frame) -> float:
    """Return the length of the longest pixel ray whose depth is 1."""
    height, width = frame.depth_m.shape
    x = max(frame.K[0, 2], width - frame.K[0, 2]) / frame.K[0, 0]
    y = max(frame.K[1, 2], height - frame.K[1, 2]) / frame.K[1, 1]
    return float(np.sqrt(1 + x * x + y * y))


def _depth_of_map(depth_m: Float32) -> Float64:
    """Return the depth smoothed as the map smooths it, or points would miss their own voxels."""
    _, mean = inverse_depth(depth_m, depth_m > 0, WINDOW_RADIUS_PX)
    return smoothed_depth(depth_m, mean, SAME_SURFACE)


def _runs(coord: Int32) -> tuple[Int64, Int64]:
    """Return the columns of (3, M) that differ from the one before, and which each column repeats.

    Neighbouring pixels often share a voxel: fewer coordinates to look up.
    """
    starts = np.ones(coord.shape[1], np.bool_)
    starts[1:] = (coord[:, 1:] != coord[:, :-1]).any(axis=0)
    return np.flatnonzero(starts), np.cumsum(starts) - 1
