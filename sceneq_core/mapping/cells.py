"""Cubes of 8 x 8 x 8 voxels: the unit in which the map finds neighbours and what is in view."""

import numpy as np

from sceneq_core.arrays import Float64, Int32
from sceneq_core.mapping.rows import with_rows
from sceneq_core.mapping.voxel_index import VoxelIndex

CELL_BITS = 3
CELL_SIDE = 1 << CELL_BITS
CELL_SLOTS = CELL_SIDE**3


def slot_of(coord: Int32) -> Int32:
    """Return the slot int32 (N,) of voxel ``coord`` int32 (N, 3) inside its cell."""
    local = coord & (CELL_SIDE - 1)
    slot: Int32 = (local[:, 0] * CELL_SIDE + local[:, 1]) * CELL_SIDE + local[:, 2]
    return slot


class Cells:
    """Which voxels lie in which cell; cells have dense ids in first-seen order."""

    def __init__(self) -> None:
        self._index = VoxelIndex()
        self._coord = np.zeros((64, 3), np.int32)
        self._voxel_id = np.full((64, CELL_SLOTS), -1, np.int32)

    def __len__(self) -> int:
        return len(self._index)

    def add(self, voxel_id: Int32, coord: Int32) -> None:
        """Enter new voxels."""
        cell_coord = coord >> CELL_BITS
        cell_id = self._index.insert(cell_coord)
        self._coord = with_rows(self._coord, len(self), 0)
        self._voxel_id = with_rows(self._voxel_id, len(self), -1)
        self._coord[cell_id] = cell_coord
        self._voxel_id[cell_id, slot_of(coord)] = voxel_id

    def of(self, coord: Int32) -> Int32:
        """Return the cell ids int32 (N,) of voxel coordinates, -1 where there is no cell."""
        return self._index.lookup(coord >> CELL_BITS)

    def voxels(self, cell_id: Int32) -> Int32:
        """Return the ids of all voxels in these cells, in the order of cells and slots."""
        inside = self._voxel_id[cell_id]
        return inside[inside >= 0]

    def centres_world(self, voxel_size_m: float) -> Float64:
        """Return the cell centres float64 (C, 3), metres."""
        middle = self._coord[: len(self)].astype(np.float64) + 0.5
        return middle * (CELL_SIDE * voxel_size_m)
