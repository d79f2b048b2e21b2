"""Where groups of superpoints touch, and how much of the border the surface goes on across."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Array, Float64, Int32, Int64
from sceneq_core.mapping.tally import Tally

SHIFT = 32
LOW = (1 << SHIFT) - 1
"""Pairs are packed: the first superpoint above, the second one below."""


@dataclass(frozen=True, slots=True)
class Near:
    """Which groups superpoints border on, parallel rows without repetition.

    ``row`` int64 (C,) counts in the superpoints that were asked for, ``group`` int32 (C,) is never
    -1, ``share`` float64 (C,) is that of the superpoint's border across which its surface goes on
    into the group.
    """

    row: Int64
    group: Int32
    share: Float64


@dataclass(frozen=True, slots=True, eq=False)
class Borders:
    """Sums over pairs of superpoints, each under both of them, and the ``group`` of each (S,).

    ``length`` of their border, and the ``unbent`` part of it; superpoints ``in_view``.
    """

    length: Tally
    unbent: Tally
    in_view: Int32
    group: Int32

    def around(self, superpoint_id: Int32) -> Near:
        """Return what those of the superpoints border on that are out of view.

        What is in view is decided by what is seen alone: the views to come know better.
        """
        place = np.full(len(self.group), -1, np.int64)
        place[superpoint_id] = np.arange(len(superpoint_id))
        place[self.in_view] = -1
        row = place[self.length.key >> SHIFT]
        length = np.bincount(row[row >= 0], self.length.total[row >= 0], len(superpoint_id))
        pair = self.unbent.key
        row, group = place[pair >> SHIFT], self.group[pair & LOW]
        known = np.flatnonzero((row >= 0) & (group >= 0))
        key, entry = np.unique(row[known] << SHIFT | group[known], return_inverse=True)
        unbent = np.bincount(entry, self.unbent.total[known], len(key))
        row = key >> SHIFT
        return Near(row, (key & LOW).astype(np.int32), unbent / length[row])

    def openness(self, first: Array, second: Array) -> Float64:
        """Return the unbent share of the border of group pairs, float64 (P,); 0 without one."""
        pair = np.minimum(first, second).astype(np.int64) << SHIFT | np.maximum(first, second)
        asked, row = np.unique(pair, return_inverse=True)
        length, unbent = self._between(self.length, asked), self._between(self.unbent, asked)
        return np.asarray((unbent / np.maximum(length, 1))[row])

    def openness_of_parts(self, superpoint_id: Int32, part: Int64, former: Int32) -> Float64:
        """Return that of the border between each part, float64 (P,), and the rest of its group.

        ``part`` int64 (N,) from 0 is that of distinct superpoints, ``former`` int32 (P,) the group
        of each part.
        """
        group, first = self.group.copy(), int(self.group.max(initial=-1)) + 1
        group[superpoint_id] = first + part
        apart = Borders(self.length, self.unbent, self.in_view, group)
        return apart.openness(former, np.arange(first, first + len(former)))

    def _between(self, tally: Tally, asked: Int64) -> Float64:
        """Return the sums between group pairs ``asked``, packed and sorted (P,)."""
        first, second = self.group[tally.key >> SHIFT], self.group[tally.key & LOW]
        known = (first >= 0) & (first < second)
        key = first[known].astype(np.int64) << SHIFT | second[known]
        place = np.searchsorted(asked, key)
        hit = np.append(asked, -1)[place] == key
        total = np.bincount(place[hit], tally.total[known][hit], len(asked))
        return total.astype(np.float64)
