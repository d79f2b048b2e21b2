"""Cubes of 8 x 8 x 8 voxels: the unit in which the map finds voxels and what is in view.

The *place* of a voxel is the number of its cell times ``CELL_SLOTS`` plus its slot in the cell.
"""

import numpy as np

from sceneq_core.arrays import Float64, Int32, Int64
from sceneq_core.mapping.rows import runs, with_rows
from sceneq_core.mapping.voxel_index import VoxelIndex

CELL_BITS = 3
CELL_SIDE = 1 << CELL_BITS
CELL_SLOTS = CELL_SIDE**3
SLOT_BITS = 3 * CELL_BITS

_SLOT_COORD = np.stack(np.unravel_index(np.arange(CELL_SLOTS), (CELL_SIDE,) * 3), axis=1)
SLOT_COORD: Int32 = _SLOT_COORD.astype(np.int32)
"""The coordinates int32 (512, 3) of each slot inside its cell."""


class Cells:
    """Which voxel is where; cells have dense ids in first-seen order."""

    def __init__(self) -> None:
        self._index = VoxelIndex()
        self._coord = np.zeros((64, 3), np.int32)
        # One more than the voxel id, 0 = none: zeroed memory costs nothing until it is used.
        self._occupant = np.zeros((64, CELL_SLOTS), np.int32)

    def __len__(self) -> int:
        return len(self._index)

    def enter(self, coord: Int32) -> Int32:
        """Return the places int32 (N,) of voxel ``coord`` int32 (N, 3), with cells for them."""
        cell_coord = coord >> CELL_BITS
        # Neighbouring points are often in one cell: fewer coordinates to look up.
        first, of_point = runs(cell_coord)
        cell_id = self._index.insert(cell_coord.take(first, axis=0))
        self._coord = with_rows(self._coord, len(self), 0)
        self._occupant = with_rows(self._occupant, len(self), 0)
        self._coord[cell_id] = cell_coord.take(first, axis=0)
        local = coord & (CELL_SIDE - 1)
        slot = (local[:, 0] << 2 * CELL_BITS) | (local[:, 1] << CELL_BITS) | local[:, 2]
        place: Int32 = (cell_id.take(of_point) << SLOT_BITS) | slot
        return place

    def occupants(self, place: Int32) -> Int32:
        """Return the voxel ids int32 (N,) at ``place``, -1 = none yet."""
        return self._occupant.reshape(-1).take(place) - 1

    def occupy(self, place: Int32, voxel_id: Int32) -> None:
        """Let ``voxel_id`` be what is at ``place`` from now on."""
        self._occupant.reshape(-1)[place] = voxel_id + 1

    def coord(self, place: Int32) -> Int32:
        """Return the voxel coordinates int32 (N, 3) of places."""
        coord = self._coord.take(place >> SLOT_BITS, axis=0) << CELL_BITS
        coord += SLOT_COORD.take(place & (CELL_SLOTS - 1), axis=0)
        return coord

    def of(self, coord: Int32) -> Int32:
        """Return the cell ids int32 (N,) of voxel coordinates, -1 where there is no cell."""
        return self._index.lookup(coord >> CELL_BITS)

    def voxels(self, cell_id: Int32) -> Int32:
        """Return the ids of all voxels in these cells, in the order of cells and slots."""
        return self.contents(cell_id)[0]

    def contents(self, cell_id: Int32) -> tuple[Int32, Int64, Int64]:
        """Return ``voxels`` of these cells with, for each, the row of its cell and its slot."""
        inside = self._occupant.take(cell_id, axis=0).reshape(-1)
        where = np.flatnonzero(inside != 0)  # of bool it is five times as quick as of int32
        return inside.take(where) - 1, where >> SLOT_BITS, where & (CELL_SLOTS - 1)

    def origins(self, cell_id: Int32) -> Int32:
        """Return the smallest voxel coordinates int32 (C, 3) in these cells."""
        return self._coord.take(cell_id, axis=0) << CELL_BITS

    def centres_world(self, voxel_size_m: float) -> Float64:
        """Return the cell centres float64 (C, 3), metres."""
        middle = self._coord[: len(self)].astype(np.float64) + 0.5
        return middle * (CELL_SIDE * voxel_size_m)
