"""What pairs of groups out of view are to each other, kept as long as neither of them changes."""

import numpy as np

from sceneq_core.arrays import Array, Bool, Float64, Int64
from sceneq_core.mapping.borders import LOW, SHIFT, Borders
from sceneq_core.mapping.rows import sorted_keys, with_rows


class Kinships:
    """The meetings and the kinship of groups, as ``Borders`` tells them, worked out only once.

    What is out of view stays as it is for a long time. Pairs that are not asked for are forgotten,
    so that there are never more than candidates for merging.
    """

    def __init__(self) -> None:
        self._now = 0
        self._changed = np.zeros(0, np.int64)
        self._met = np.zeros(0, np.int64)
        self._meeting = np.zeros(0, np.int64)
        self._pair = np.zeros(0, np.int64)
        self._kinship = np.zeros(0)
        self._known = 0

    def forget(self, group: Array) -> None:
        """Note that these groups, -1 = none, their borders or their colours are others now."""
        self._now += 1
        count = int(group.max(initial=-1)) + 2  # the last one is that of no group
        self._changed = with_rows(self._changed, count, 0)
        self._met = with_rows(self._met, count, 0)
        self._changed[group] = self._now

    def meeting(self, borders: Borders, in_view: Bool) -> Int64:
        """Return the pairs (P,) of groups that the surface goes on between, packed and sorted.

        Those of which one is ``in_view`` bool (G,) are left out.
        """
        groups = min(len(in_view), len(self._changed))
        stale = ~in_view
        stale[groups:] = False
        stale[:groups] &= self._changed[:groups] > self._met[:groups]
        pair = self._meeting
        left_out = stale | in_view
        kept = pair.compress(~(left_out[pair >> SHIFT] | left_out[pair & LOW]))
        if stale.any():
            new = borders.meeting(np.flatnonzero(stale))
            new = new.compress(~(in_view[new >> SHIFT] | in_view[new & LOW]))
            kept = sorted_keys(kept, new)
            self._met[:groups][stale[:groups]] = self._now
        self._meeting = kept
        return kept

    def of(self, borders: Borders, first: Int64, second: Int64) -> Float64:
        """Return the kinship of distinct group pairs, sorted, float64 (P,)."""
        pair = first << SHIFT | second
        place = np.searchsorted(self._pair, pair)
        known = np.append(self._pair, -1).take(place) == pair
        latest = np.maximum(self._changed[first], self._changed[second])
        known &= latest <= self._known
        kinship = np.append(self._kinship, 0.0).take(place)
        new = np.flatnonzero(~known)
        kinship[new] = borders.kinship(first[new], second[new])
        self._pair, self._kinship, self._known = pair, kinship, self._now
        return kinship
