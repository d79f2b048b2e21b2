"""Where groups of superpoints touch, and how much of the border the surface goes on across."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Array, Bool, Float64, Int32, Int64
from sceneq_core.mapping.colours import Palette
from sceneq_core.mapping.rows import marked, sorted_keys
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

    ``length`` of their border, and the ``unbent`` part of it; their colours in the ``palette``;
    superpoints ``in_view``.
    """

    length: Tally
    unbent: Tally
    palette: Palette
    in_view: Int32
    group: Int32

    def around(self, superpoint_id: Int32) -> Near:
        """Return what those of the superpoints border on that are out of view.

        What is in view is decided by what is seen alone: the views to come know better.
        """
        place = np.full(len(self.group), -1, np.int64)
        place[superpoint_id] = np.arange(len(superpoint_id))
        place[self.in_view] = -1
        asked = np.flatnonzero(place >= 0)
        entry = self.length.under(asked, SHIFT)
        row = place.take(self.length.key.take(entry) >> SHIFT)
        length = np.bincount(row, self.length.total.take(entry), len(superpoint_id))
        entry = self.unbent.under(asked, SHIFT)
        pair = self.unbent.key.take(entry)
        group = self.group.take(pair & LOW)
        known = np.flatnonzero(group >= 0)
        row = place.take(pair.take(known) >> SHIFT)
        key, of_entry = np.unique(row << SHIFT | group.take(known), return_inverse=True)
        unbent = np.bincount(of_entry, self.unbent.total.take(entry.take(known)), len(key))
        row = key >> SHIFT
        return Near(row, (key & LOW).astype(np.int32), unbent / length[row])

    def openness(self, first: Array, second: Array) -> Float64:
        """Return the unbent share of the border of group pairs, float64 (P,); 0 without one."""
        if not len(first):
            return np.zeros(0)
        pair = np.minimum(first, second).astype(np.int64) << SHIFT | np.maximum(first, second)
        asked, row = np.unique(pair, return_inverse=True)
        inside = self._members(asked & LOW)
        length, unbent = (self._between(t, asked, inside) for t in (self.length, self.unbent))
        return np.asarray((unbent / np.maximum(length, 1))[row])

    def meeting(self, group: Int64) -> Int64:
        """Return the pairs (P,) that the surface goes on between and one of which is in ``group``.

        They are packed and sorted.
        """
        key = self.unbent.key.take(self.unbent.under(self._members(group), SHIFT))
        one, other = self.group.take(key >> SHIFT), self.group.take(key & LOW)
        known = np.flatnonzero((one != other) & (other >= 0))
        one, other = one.take(known).astype(np.int64), other.take(known)
        return sorted_keys(np.minimum(one, other) << SHIFT | np.maximum(one, other))

    def kinship(self, first: Array, second: Array) -> Float64:
        """Return how much group pairs look like one thing, float64 (P,), 0 to 1.

        The geometric mean of the openness of their border and the colours that they have in common:
        an armchair's seat goes on into its back and is of the same stuff; a table top may go on
        into a tray, and a white wall has the colour of a white shelf.
        """
        openness = self.openness(first, second)
        touch = np.flatnonzero(openness > 0)
        common = self.palette.common(self.group, first[touch], second[touch])
        openness[touch] = np.sqrt(openness[touch] * common)
        return openness

    def kinship_of_parts(
        self, superpoint_id: Int32, part: Int64, former: Int32, asked: Bool
    ) -> Float64:
        """Return that of the ``asked`` parts (P,) with the rest of their groups, float64 (A,).

        ``part`` int64 (N,) from 0 is that of distinct superpoints, ``former`` int32 (P,) the group
        of each part.
        """
        group, first = self.group.copy(), int(self.group.max(initial=-1)) + 1
        group[superpoint_id] = first + part
        apart = Borders(self.length, self.unbent, self.palette, self.in_view, group)
        return apart.kinship(former[asked], first + np.flatnonzero(asked))

    def _members(self, group: Array) -> Int64:
        """Return the superpoints, sorted, of groups."""
        largest = max(int(self.group.max(initial=0)), int(group.max(initial=0)))
        return np.flatnonzero(marked(group, largest + 2)[self.group])

    def _between(self, tally: Tally, asked: Int64, inside: Int64) -> Float64:
        """Return the sums between group pairs ``asked``, packed and sorted (P,).

        ``inside`` are the superpoints of the second ones.
        """
        entry = tally.under(inside, SHIFT)
        key = tally.key.take(entry)
        second, first = self.group.take(key >> SHIFT), self.group.take(key & LOW)
        # Most pairs are of one group: what is left are the borders.
        known = np.flatnonzero((first < second) & (first >= 0))
        key = first.take(known).astype(np.int64) << SHIFT | second.take(known)
        place = np.searchsorted(asked, key)
        hit = np.flatnonzero(np.append(asked, -1).take(place) == key)
        total = tally.total.take(entry.take(known.take(hit)))
        return np.bincount(place.take(hit), total, len(asked)).astype(np.float64)
