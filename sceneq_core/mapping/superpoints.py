"""Over-segmentation of the voxels by normal and colour, kept up to date cell by cell."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Int32
from sceneq_core.mapping.ids import Ids
from sceneq_core.mapping.partition import SuperpointParams, VoxelFeatures, partition
from sceneq_core.mapping.rows import distinct, first_of_each, marked, with_rows
from sceneq_core.mapping.voxels import Voxels

_MUCH_NEW = 8
"""A cell has gained much surface when this many times the new voxels exceed those seen."""


@dataclass(frozen=True, slots=True)
class SuperpointChange:
    """What an update did to the superpoints, all int32.

    ``new_id`` (A,) came out of ``parent_id`` (A,), -1 = out of nothing; ``gone_id`` (B,) ended.
    """

    new_id: Int32
    parent_id: Int32
    gone_id: Int32


class Superpoints:
    """The superpoint of every voxel; an id stays with the part that keeps most of its voxels.

    Ids of vanished superpoints are given again, so tables by id stay as small as the surface.
    """

    def __init__(self, params: SuperpointParams) -> None:
        self._params = params
        self._of_voxel = np.full(0, -1, np.int32)
        self._cell = np.full(0, -1, np.int32)
        self._ids = Ids()

    def __len__(self) -> int:
        """Return one more than the largest id given so far."""
        return len(self._ids)

    def of(self, voxel_id: Int32) -> Int32:
        """Return the superpoint ids of voxels, -1 = none."""
        return self._of_voxel[voxel_id]

    def voxels(self, voxels: Voxels, superpoint_id: Int32) -> Int32:
        """Return the voxels of these superpoints, in the order of their cells."""
        wanted = marked(superpoint_id, len(self))
        inside = voxels.cells.voxels(distinct(self._cell[superpoint_id], len(voxels.cells)))
        superpoint = self._of_voxel[inside]
        return inside[(superpoint >= 0) & wanted[superpoint]]

    def update(
        self, voxels: Voxels, touched_id: Int32, cleared_id: Int32, keyframe: int
    ) -> tuple[Int32, SuperpointChange]:
        """Partition cells of these voxels anew; return the voxels partitioned and the change."""
        self._of_voxel = with_rows(self._of_voxel, len(voxels), -1)
        cell_id = self._due_cells(voxels, touched_id, cleared_id, keyframe)
        inside = voxels.cells.voxels(cell_id)
        before = self._of_voxel[inside]
        before = distinct(before[before >= 0], len(self))
        self._of_voxel[cleared_id] = -1
        voxel_id = voxels.occupied(inside)
        part = partition(
            VoxelFeatures(
                voxels.coord(voxel_id), voxels.normals_world(voxel_id), voxels.colours(voxel_id)
            ),
            self._params,
        )
        change = self._rename(voxel_id, part, before)
        self._cell = with_rows(self._cell, len(self), -1)
        self._cell[self._of_voxel[voxel_id]] = voxels.cells.of(voxels.coord(voxel_id))
        return voxel_id, change

    def _due_cells(
        self, voxels: Voxels, touched_id: Int32, cleared_id: Int32, keyframe: int
    ) -> Int32:
        """Return the touched cells that lost surface, gained much of it, or whose turn it is."""
        cell = voxels.cells.of(voxels.coord(touched_id))
        count = len(voxels.cells)
        new = np.bincount(cell[self._of_voxel[touched_id] < 0], minlength=count)
        touched = np.bincount(cell, minlength=count)
        turn = (np.arange(count) + keyframe) % self._params.refresh_keyframes == 0
        due = (touched > 0) & (turn | (_MUCH_NEW * new > touched))
        due[voxels.cells.of(voxels.coord(cleared_id))] = True
        return np.flatnonzero(due).astype(np.int32)

    def _rename(self, voxel_id: Int32, part: Int32, before: Int32) -> SuperpointChange:
        heir, parent = _match(part, self._of_voxel[voxel_id])
        gone = before[~marked(heir[heir >= 0], len(self))[before]]
        new = heir < 0
        new_id = self._ids.take(int(new.sum()))
        heir[new] = new_id
        self._of_voxel[voxel_id] = heir[part]
        self._ids.give_back(gone)
        return SuperpointChange(new_id, parent[new], gone)


def _match(part: Int32, old: Int32) -> tuple[Int32, Int32]:
    """Return per part the old id it keeps (or -1) and the old id it overlaps most (or -1).

    A part keeps an old id when each is the other's largest overlap.
    """
    count = int(part.max(initial=-1)) + 1
    heir, parent = np.full(count, -1, np.int32), np.full(count, -1, np.int32)
    known = old >= 0
    span = int(old.max(initial=0)) + 1
    pair, overlap = np.unique(part[known] * np.int64(span) + old[known], return_counts=True)
    pair_part, pair_old = pair // span, pair % span
    largest_old = first_of_each(np.lexsort((pair_old, -overlap, pair_part)), pair_part)
    largest_part = first_of_each(np.lexsort((pair_part, -overlap, pair_old)), pair_old)
    parent[pair_part[largest_old]] = pair_old[largest_old]
    mutual = np.intersect1d(largest_old, largest_part)
    heir[pair_part[mutual]] = pair_old[mutual]
    return heir, parent
