"""Which voxel every pixel of a keyframe shows: visibility that is depth-tested by construction.

A *place* is a voxel coordinate the map has used. Places are numbered for ever, unlike voxel ids,
which start again when the writer of the map does; so what a keyframe shows stays true while
voxels, superpoints and instances change around it.
"""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Array, Float64, Int32
from sceneq_core.frame import Frame
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.mapping.voxel_index import COORD_LIMIT, VoxelIndex

STRIDE_PX = 2
NO_PLACE = -1


@dataclass(frozen=True, slots=True)
class PlaceImage:
    """The place of every second pixel of every second row, -1 = none, as runs along the rows.

    ``place`` int32 (R,) and ``length`` int32 (R,) in row order; ``shape`` is that of the image at
    half resolution. Runs because neighbouring pixels share a voxel: a third of the memory, and
    counting looks at a third of the values.
    """

    place: Int32
    length: Int32
    shape: tuple[int, int]

    def expand(self, value: Array) -> Array:
        """Return the image (H/2, W/2) of one value per run."""
        return np.repeat(value, self.length).reshape(self.shape)


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
        self._place_of_voxel[voxel_id] = self._index.insert(voxel_coord)

    def instance_of_place(self, replica: MapReplica) -> Int32:
        """Return the instance at each place, int32 (P + 1,); the last one, for -1, is 0."""
        instance_id = np.zeros(len(self) + 1, np.int32)
        place = self._place_of_voxel[: replica.voxel_count]
        instance_id[place] = replica.instance_of_voxel()
        instance_id[NO_PLACE] = 0
        return instance_id

    def render(self, frame: Frame, voxel_size_m: float) -> PlaceImage:
        """Return the places that ``frame`` shows, at half resolution."""
        points_voxel, valid = _points_in_voxels(frame, voxel_size_m)
        coord = np.floor(points_voxel)
        first = _run_starts(coord, valid)
        place = np.full(len(first), NO_PLACE, np.int32)
        known = valid.ravel()[first]
        place[known] = self._nearest(coord.reshape(-1, 3)[first[known]], points_voxel, first[known])
        length = np.diff(first, append=valid.size).astype(np.int32)
        return PlaceImage(place, length, (valid.shape[0], valid.shape[1]))

    def _nearest(self, coord: Float64, points_voxel: Float64, pixel: Array) -> Int32:
        """Return the place at each coordinate or, where there is none, at the closest face.

        The map leaves out depth edges and grazing views; half a voxel away is the same surface.
        """
        place = self._index.lookup(coord.astype(np.int32))
        offset = points_voxel.reshape(-1, 3)[pixel] - coord - 0.5
        for rank in (2, 1, 0):
            missing = np.flatnonzero(place < 0)
            if not len(missing):
                break
            axis = np.argsort(np.abs(offset[missing]), axis=1, kind="stable")[:, rank]
            beside = coord[missing]
            beside[np.arange(len(missing)), axis] += np.sign(offset[missing, axis])
            place[missing] = self._index.lookup(beside.astype(np.int32))
        return place


def _points_in_voxels(frame: Frame, voxel_size_m: float) -> tuple[Float64, Array]:
    """Return back-projected pixels (H/2, W/2, 3) in voxel units of the world, and which are valid.

    Depth without a measurement and points outside the index are not valid.
    """
    depth_m = frame.depth_m[::STRIDE_PX, ::STRIDE_PX].astype(np.float64)
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


def _run_starts(coord: Float64, valid: Array) -> Array:
    """Return the flat indices of the pixels that differ from their left neighbour."""
    start = np.ones(valid.shape, np.bool_)
    same_voxel = (coord[:, 1:] == coord[:, :-1]).all(axis=-1)
    both, neither = valid[:, 1:] & valid[:, :-1], ~valid[:, 1:] & ~valid[:, :-1]
    start[:, 1:] = ~(both & same_voxel | neither)
    return np.flatnonzero(start)
