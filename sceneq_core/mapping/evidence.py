"""The evidence table: which 2D segment dominates something in which keyframe."""

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int32, Int64
from sceneq_core.mapping.rows import with_rows

NO_SEGMENT = -1


def agreement(same: Int64, common: Int64) -> Float64:
    """Return the expected share of common views with equal segments, 0.5 without any evidence.

    The paper's Agree(a, b), as the mean of a Beta(1/2, 1/2) posterior: one view alone says 0.75 or
    0.25, never 1 or 0.
    """
    return (same + 0.5) / (common + 1.0)


class Evidence:
    """Per row (a superpoint or an instance) the segments of its latest keyframes.

    Keyframe number n is kept in slot n mod ``views``: what is seen together is comparable slot by
    slot, and the memory is bounded by the number of rows, not of keyframes.
    """

    def __init__(self, views: int) -> None:
        self._views = views
        self._keyframe = np.full((0, views), -1, np.int32)
        self._segment = np.full((0, views), NO_SEGMENT, np.int32)

    def reserve(self, count: int) -> None:
        """Make room for rows up to ``count``."""
        self._keyframe = with_rows(self._keyframe, count, -1)
        self._segment = with_rows(self._segment, count, NO_SEGMENT)

    def record(self, row: Int32, keyframe: int, segment: Int32) -> None:
        """Note the dominant ``segment`` of each row in a keyframe; segments are unique numbers."""
        slot = keyframe % self._views
        self._keyframe[row, slot] = keyframe
        self._segment[row, slot] = segment

    def forget(self, row: Int32) -> None:
        """Empty these rows."""
        self._keyframe[row] = -1
        self._segment[row] = NO_SEGMENT

    def copy(self, row: Int32, source: "Evidence", source_row: Int32) -> None:
        """Let ``row`` start with the evidence of ``source_row``."""
        self._keyframe[row] = source._keyframe[source_row]
        self._segment[row] = source._segment[source_row]

    def compare(self, row: Int32, other: "Evidence", other_row: Int32) -> tuple[Int64, Int64]:
        """Return (views with equal segments, common views) of row pairs, both int64 (N,)."""
        segment, other_segment = self._segment[row], other._segment[other_row]
        common = self._keyframe[row] == other._keyframe[other_row]
        common &= (segment != NO_SEGMENT) & (other_segment != NO_SEGMENT)
        same = common & (segment == other_segment)
        return same.sum(axis=1), common.sum(axis=1)

    def take_majority(self, row: Int32, source: "Evidence", source_row: Int32, of: Int32) -> None:
        """Set ``row[of[i]]`` to the majority, slot by slot, of its members ``source_row[i]``.

        The newest keyframe in a slot wins over older ones, then the segment with most members.
        """
        member, slot = np.nonzero(source._segment[source_row] != NO_SEGMENT)
        keyframe = source._keyframe[source_row[member], slot]
        segment = source._segment[source_row[member], slot]
        votes = np.stack((of[member], slot, keyframe, segment)).astype(np.int64)
        votes, count = _distinct_columns(votes)
        order = np.lexsort((-votes[3], count, votes[2], votes[1], votes[0]))
        target, slot, keyframe, segment = votes[:, order]
        last = _last_of_each(target * self._views + slot)
        self.forget(row)
        self._keyframe[row[target[last]], slot[last]] = keyframe[last]
        self._segment[row[target[last]], slot[last]] = segment[last]

    def absorb(self, row: int, other_row: int) -> None:
        """Let ``row`` take what ``other_row`` saw later, slot by slot."""
        newer = self._keyframe[other_row] > self._keyframe[row]
        self._keyframe[row, newer] = self._keyframe[other_row, newer]
        self._segment[row, newer] = self._segment[other_row, newer]


def _distinct_columns(table: Int64) -> tuple[Int64, Int64]:
    """Return the distinct columns of ``table`` (R, N) and how often each occurs."""
    table = table[:, np.lexsort(table)]
    changed = np.ones(table.shape[1], np.bool_)
    changed[1:] = (table[:, 1:] != table[:, :-1]).any(axis=0)
    start = np.flatnonzero(changed)
    return table[:, start], np.diff(np.append(start, table.shape[1]))


def _last_of_each(key: Int64) -> Bool:
    """Mark the last row of every run of equal keys."""
    last = np.ones(len(key), np.bool_)
    last[:-1] = key[1:] != key[:-1]
    return last
