"""Over-segmentation of the voxels by normal and colour, kept up to date cell by cell."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Int32
from sceneq_core.mapping.ids import Ids
from sceneq_core.mapping.partition import SuperpointParams, VoxelFeatures, partition
from sceneq_core.mapping.ragged import Ragged
from sceneq_core.mapping.rows import (
    counted,
    distinct,
    largest_of_runs,
    marked,
    stable_order,
    with_rows,
)
from sceneq_core.mapping.voxels import Moved, Voxels

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
        self._voxels = Ragged()
        self._ids = Ids()
        # Per cell, how many voxels of it keyframes touched: so far, and up to its last partition.
        self._seen = np.zeros(0, np.int64)
        self._partitioned = np.zeros(0, np.int64)

    def __len__(self) -> int:
        """Return one more than the largest id given so far."""
        return len(self._ids)

    def reserve(self, count: int) -> None:
        """Make room for voxel ids below ``count``; they have no superpoint yet."""
        self._of_voxel = with_rows(self._of_voxel, count, -1)

    def of(self, voxel_id: Int32) -> Int32:
        """Return the superpoint ids of voxels, -1 = none."""
        return self._of_voxel.take(voxel_id)

    def voxels(self, superpoint_id: Int32) -> Int32:
        """Return the voxels of these superpoints, one superpoint after the other."""
        return self._voxels.of(superpoint_id)

    def update(
        self, voxels: Voxels, touched_id: Int32, cleared_id: Int32, keyframe: int
    ) -> tuple[Int32, SuperpointChange]:
        """Partition cells of these voxels anew; return the voxels partitioned and the change."""
        self.reserve(len(voxels))
        inside = voxels.cells.voxels(self._due_cells(voxels, touched_id, cleared_id, keyframe))
        before = self.of(inside)
        self._of_voxel[cleared_id] = -1
        return self._repartition(voxels, inside, before)

    def carry(self, voxels: Voxels, moved: Moved) -> tuple[Int32, SuperpointChange]:
        """Let superpoints go with the surface of their voxels; partition where it was and is.

        A superpoint lies in one cell: what of it comes into another one goes on as its child.
        """
        self.reserve(len(voxels))
        both = np.concatenate((moved.from_id, moved.to_id))
        inside = voxels.cells.voxels(distinct(voxels.cell(both), len(voxels.cells)))
        before = self.of(inside)
        carried = self.of(moved.from_id)[moved.heaviest]
        self._of_voxel[moved.from_id] = -1
        self._of_voxel[moved.to_id[moved.heaviest]] = carried
        return self._repartition(voxels, inside, before)

    def _repartition(
        self, voxels: Voxels, inside: Int32, before: Int32
    ) -> tuple[Int32, SuperpointChange]:
        """Partition the voxels ``inside`` of cells, which had the superpoints ``before``."""
        before = distinct(before[before >= 0], len(self))
        voxel_id = voxels.occupied(inside)
        features = VoxelFeatures(voxels.coord(voxel_id), *voxels.features(voxel_id))
        part = partition(features, self._params)
        change = self._rename(voxel_id, part, before)
        self._voxels.forget(change.gone_id)
        superpoint = self.of(voxel_id)
        count = np.bincount(superpoint)
        superpoint_id = np.flatnonzero(count).astype(np.int32)
        in_order = voxel_id.take(stable_order(superpoint))
        self._voxels.put(superpoint_id, count.take(superpoint_id), in_order)
        return voxel_id, change

    def _due_cells(
        self, voxels: Voxels, touched_id: Int32, cleared_id: Int32, keyframe: int
    ) -> Int32:
        """Return the cells that lost surface, gained much of it, or whose turn has come."""
        cell, count = voxels.cell(touched_id), len(voxels.cells)
        new = np.bincount(cell[self.of(touched_id) < 0], minlength=count)
        touched = np.bincount(cell, minlength=count)
        self._seen = with_rows(self._seen, count, 0)
        self._partitioned = with_rows(self._partitioned, count, 0)
        self._seen[:count] += touched
        turn = (np.arange(count) + keyframe) % self._params.refresh_keyframes == 0
        turn &= (new > 0) | self._has_grown(count)
        due = (touched > 0) & (turn | (_MUCH_NEW * new > touched))
        due[voxels.cell(cleared_id)] = True
        cell_id = np.flatnonzero(due).astype(np.int32)
        self._partitioned[cell_id] = self._seen[cell_id]
        return cell_id

    def _has_grown(self, count: int) -> Bool:
        """Tell which cells were seen so much more that their means may have changed."""
        grown = self._seen[:count] >= self._params.min_growth * self._partitioned[:count]
        return np.asarray(grown)

    def _rename(self, voxel_id: Int32, part: Int32, before: Int32) -> SuperpointChange:
        heir, parent = _match(part, self.of(voxel_id))
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
    span = int(old.max(initial=0)) + 1
    known = np.flatnonzero(old >= 0)
    pair, overlap = counted(part.take(known) * np.int64(span) + old.take(known))
    pair_part, pair_old = pair // span, pair % span
    largest_old = largest_of_runs(pair_part, overlap)
    by_old = np.argsort(pair_old, kind="stable")
    largest_part = by_old[largest_of_runs(pair_old[by_old], overlap[by_old])]
    parent[pair_part[largest_old]] = pair_old[largest_old]
    mutual = largest_old[marked(largest_part, len(pair))[largest_old]]
    heir[pair_part[mutual]] = pair_old[mutual]
    return heir, parent
