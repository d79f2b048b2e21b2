"""Which voxel every pixel of a keyframe shows: visibility that is depth-tested by construction.

A *place* is a voxel coordinate the map has used. Places are numbered for ever, unlike voxel ids,
which start again when the writer of the map does; so what a keyframe shows stays true while
voxels, superpoints and instances change around it.
"""

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64, Int32, Int64
from sceneq_core.frame import Frame
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.mapping.voxel_index import COORD_LIMIT, VoxelIndex

STRIDE_PX = 2
NO_PLACE = -1
WINDOW_PX = (5, 5)
SAME_SURFACE = 0.02
"""Depths that differ by less than this share of the depth belong to one surface."""


class Places:
    """Numbers the places of a map and finds those that a frame shows."""

    def __init__(self) -> None:
        self._index = VoxelIndex()
        self._place_of_voxel = np.zeros(0, np.int32)

    def __len__(self) -> int:
        return len(self._index)

    def forget_voxels(self) -> None:
        """Start again with voxel ids; places keep their numbers."""
        self._place_of_voxel = np.zeros(0, np.int32)

    def learn(self, voxel_id: Int32, voxel_coord: Int32) -> None:
        """Take over that voxel ids (M,) lie at grid coordinates (M, 3)."""
        missing = int(voxel_id.max(initial=-1)) + 1 - len(self._place_of_voxel)
        if missing > 0:
            room = np.full(max(missing, len(self._place_of_voxel)), NO_PLACE, np.int32)
            self._place_of_voxel = np.append(self._place_of_voxel, room)
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
        place[measured] = self._nearest(coord[:, first].T, points_voxel[:, first].T)[of_pixel]
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
    depth_m = _smoothed(np.ascontiguousarray(frame.depth_m[::STRIDE_PX, ::STRIDE_PX]))
    farthest_m = (COORD_LIMIT - 2) * voxel_size_m - np.abs(frame.T_world_camera[:3, 3]).max()
    measured = (depth_m > 0) & (depth_m * _longest_ray(frame) < farthest_m)
    row, column = np.nonzero(measured)
    z = depth_m[measured]
    x = (column * STRIDE_PX - frame.K[0, 2]) * (z / frame.K[0, 0])
    y = (row * STRIDE_PX - frame.K[1, 2]) * (z / frame.K[1, 1])
    T_voxel_camera = frame.T_world_camera / voxel_size_m
    # Written out: a matrix product may round otherwise with another number of threads.
    return np.stack([a * x + b * y + c * z + t for a, b, c, t in T_voxel_camera[:3]]), measured


def _longest_ray(frame: Frame) -> float:
    """Return the length of the longest pixel ray whose depth is 1."""
    height, width = frame.depth_m.shape
    x = max(frame.K[0, 2], width - frame.K[0, 2]) / frame.K[0, 0]
    y = max(frame.K[1, 2], height - frame.K[1, 2]) / frame.K[1, 1]
    return float(np.sqrt(1 + x * x + y * y))


def _smoothed(depth_m: Float32) -> Float64:
    """Return the depth with the noise of the sensor averaged out, as the map does.

    Inverse depth, because a plane is linear in it; not across edges, where the mean is far off.
    """
    valid = depth_m > 0
    inverse = np.where(valid, 1.0 / np.maximum(depth_m, np.float32(1e-3)), np.float32(0))
    share = np.maximum(cv2.blur(valid.astype(np.float32), WINDOW_PX), np.float32(1e-6))
    mean_m = share.astype(np.float64) / np.maximum(cv2.blur(inverse, WINDOW_PX), 1e-6)
    z = depth_m.astype(np.float64)
    return np.where(np.abs(mean_m - z) < SAME_SURFACE * z, mean_m, z)


def _runs(coord: Int32) -> tuple[Int64, Int64]:
    """Return the columns of (3, M) that differ from the one before, and which each column repeats.

    Neighbouring pixels often share a voxel: fewer coordinates to look up.
    """
    starts = np.ones(coord.shape[1], np.bool_)
    starts[1:] = (coord[:, 1:] != coord[:, :-1]).any(axis=0)
    return np.flatnonzero(starts), np.cumsum(starts) - 1
