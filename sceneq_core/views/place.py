"""Which voxel every pixel of a keyframe shows: visibility that is depth-tested by construction.

A *place* is a voxel coordinate the map has used. Places are numbered for ever, unlike voxel ids,
which start again when the writer of the map does; so what a keyframe shows stays true while
voxels, superpoints and instances change around it.
"""

import cv2
import numpy as np

from sceneq_core.arrays import Array, Float32, Float64, Int32
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
        points_voxel, valid = _points_in_voxels(frame, voxel_size_m)
        measured = points_voxel[valid]
        coord = np.floor(measured).astype(np.int32)
        first, of_pixel = _runs(coord)
        place = np.full(valid.shape, NO_PLACE, np.int32)
        place[valid] = self._nearest(coord[first], measured[first])[of_pixel]
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


def _points_in_voxels(frame: Frame, voxel_size_m: float) -> tuple[Float64, Array]:
    """Return back-projected pixels (H/2, W/2, 3) in voxel units of the world, and which are valid.

    Depth without a measurement and points outside the index are not valid.
    """
    depth_m = _smoothed(np.ascontiguousarray(frame.depth_m[::STRIDE_PX, ::STRIDE_PX]))
    height, width = frame.depth_m.shape
    x = (np.arange(0, width, STRIDE_PX) - frame.K[0, 2]) / frame.K[0, 0]
    y = (np.arange(0, height, STRIDE_PX) - frame.K[1, 2]) / frame.K[1, 1]
    R_world_camera = frame.T_world_camera[:3, :3] / voxel_size_m
    ray_world = (
        x[None, :, None] * R_world_camera[:, 0]
        + y[:, None, None] * R_world_camera[:, 1]
        + R_world_camera[:, 2]
    )
    points = ray_world * depth_m[..., None] + frame.T_world_camera[:3, 3] / voxel_size_m
    inside = (np.abs(points) < COORD_LIMIT - 2).all(axis=-1)
    return points, inside & (depth_m > 0)


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


def _runs(coord: Int32) -> tuple[Array, Array]:
    """Return the rows of (M, 3) that differ from the row before, and which of them each row is in.

    Neighbouring pixels often share a voxel: fewer coordinates to look up.
    """
    starts = np.ones(len(coord), np.bool_)
    starts[1:] = (coord[1:] != coord[:-1]).any(axis=1)
    return np.flatnonzero(starts), np.cumsum(starts) - 1
