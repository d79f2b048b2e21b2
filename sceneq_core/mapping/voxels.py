"""The surface of the scene as running means in small cubes."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Array, Float32, Float64, Int32, UInt8
from sceneq_core.mapping.cells import Cells
from sceneq_core.mapping.rows import with_rows
from sceneq_core.mapping.surface import SurfacePoints
from sceneq_core.mapping.voxel_index import VoxelIndex, pack_coord, unpack_coord
from sceneq_core.vectors import unit_rows


@dataclass(frozen=True, slots=True)
class Touched:
    """The voxels one surface fell into.

    ``voxel_id`` int32 (M,) distinct; ``of_point`` int32 (N,) the row in it of every point;
    ``new_id`` int32 those of ``voxel_id`` that had never been touched before.
    """

    voxel_id: Int32
    of_point: Int32
    new_id: Int32


class Voxels:
    """Weighted sums per voxel; a voxel without weight is empty but keeps its id.

    Because only sums are kept, the order in which surfaces arrive does not matter.
    """

    def __init__(self, voxel_size_m: float) -> None:
        self.voxel_size_m = voxel_size_m
        self.cells = Cells()
        self._index = VoxelIndex()
        self._coord = np.zeros((0, 3), np.int32)
        self._weight = np.zeros(0, np.float64)
        self._position_sum = np.zeros((0, 3), np.float64)
        self._normal_sum = np.zeros((0, 3), np.float64)
        self._colour_sum = np.zeros((0, 3), np.float64)
        self.misses = np.zeros(0, np.uint8)

    def __len__(self) -> int:
        """Return the number of ids given so far, empty voxels included."""
        return len(self._index)

    def integrate(self, surface: SurfacePoints) -> Touched:
        """Add every point of ``surface`` to its voxel."""
        coord = np.floor(surface.points_world / self.voxel_size_m).astype(np.int32)
        key, inverse = np.unique(pack_coord(coord), return_inverse=True)
        of_point = inverse.astype(np.int32)
        known = len(self)
        voxel_id = self._enter(unpack_coord(key))
        weight, count = surface.weight, len(key)
        self._weight[voxel_id] += np.bincount(of_point, weight, count)
        self._position_sum[voxel_id] += _sums(surface.points_world, weight, of_point, count)
        self._normal_sum[voxel_id] += _sums(surface.normals_world, weight, of_point, count)
        self._colour_sum[voxel_id] += _sums(surface.rgb, weight, of_point, count)
        self.misses[voxel_id] = 0
        return Touched(voxel_id, of_point, voxel_id[voxel_id >= known])

    def clear(self, voxel_id: Int32) -> None:
        """Forget what these voxels hold: the space is free."""
        for table in (self._weight, self._position_sum, self._normal_sum, self._colour_sum):
            table[voxel_id] = 0.0
        self.misses[voxel_id] = 0

    def occupied(self, voxel_id: Int32) -> Int32:
        """Return those of ``voxel_id`` that hold a surface."""
        return voxel_id[self._weight[voxel_id] > 0.0]

    def coord(self, voxel_id: Int32) -> Int32:
        """Return int32 (M, 3) = floor(p / voxel_size)."""
        return self._coord[voxel_id]

    def centres_world(self, voxel_id: Int32) -> Float64:
        """Return the centres of the cubes float64 (M, 3), metres."""
        return (self._coord[voxel_id].astype(np.float64) + 0.5) * self.voxel_size_m

    def points_world(self, voxel_id: Int32) -> Float64:
        """Return mean positions float64 (M, 3), metres."""
        mean: Float64 = self._position_sum[voxel_id] / self._weight[voxel_id, None]
        return mean

    def normals_world(self, voxel_id: Int32) -> Float64:
        """Return unit normals float64 (M, 3); zero where views from both sides cancel out."""
        return unit_rows(self._normal_sum[voxel_id])

    def rgb(self, voxel_id: Int32) -> UInt8:
        """Return mean colours uint8 (M, 3)."""
        return np.rint(self._mean_colour(voxel_id)).astype(np.uint8)

    def colours(self, voxel_id: Int32) -> Float32:
        """Return mean colours float32 (M, 3) in 0..1."""
        return (self._mean_colour(voxel_id) / 255.0).astype(np.float32)

    def _mean_colour(self, voxel_id: Int32) -> Float64:
        mean: Float64 = self._colour_sum[voxel_id] / self._weight[voxel_id, None]
        return mean

    def _enter(self, coord: Int32) -> Int32:
        known = len(self)
        voxel_id = self._index.insert(coord)
        self._coord = with_rows(self._coord, len(self), 0)
        self._weight = with_rows(self._weight, len(self), 0.0)
        self._position_sum = with_rows(self._position_sum, len(self), 0.0)
        self._normal_sum = with_rows(self._normal_sum, len(self), 0.0)
        self._colour_sum = with_rows(self._colour_sum, len(self), 0.0)
        self.misses = with_rows(self.misses, len(self), 0)
        new = voxel_id >= known
        self._coord[voxel_id[new]] = coord[new]
        self.cells.add(voxel_id[new], coord[new])
        return voxel_id


def _sums(rows: Array, weight: Float64, of_point: Int32, count: int) -> Float64:
    columns = [np.bincount(of_point, column * weight, count) for column in rows.T]
    return np.stack(columns, axis=1)
