"""The evidence table: which 2D segment dominates a superpoint in which keyframe."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Array, Bool, Int32, Int64
from sceneq_core.mapping.rows import with_rows

NO_SEGMENT = 0


@dataclass(frozen=True, slots=True)
class Entries:
    """Parallel entries of the table: ``row`` int64 (N,) counts in the rows that were asked for.

    ``segment`` int32 (N,) is never ``NO_SEGMENT``; ``pixels`` int64 (N,) is more than 0.
    """

    row: Int64
    segment: Int32
    pixels: Int64


class Evidence:
    """Per superpoint the segments of its latest ``views`` keyframes with a segment.

    The oldest view makes room for a new one, so that memory is bounded by the surface, not by the
    keyframes, and a scene that changes is believed. Segments have numbers that are never reused
    and grow with the keyframes; what two rows have in common is found by these numbers.
    """

    def __init__(self, views: int) -> None:
        self._views = views
        self._segment = np.full((0, views), NO_SEGMENT, np.int32)
        self._pixels = np.zeros((0, views), np.int32)
        self._recorded = np.zeros(0, np.int32)

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self._recorded)

    def reserve(self, count: int) -> None:
        """Make room for rows up to ``count``."""
        self._segment = with_rows(self._segment, count, NO_SEGMENT)
        self._pixels = with_rows(self._pixels, count, 0)
        self._recorded = with_rows(self._recorded, count, 0)

    def record(self, row: Int32, segment: Int32, pixels: Int64) -> tuple[Int32, Int64]:
        """Note the dominant segment of distinct rows in a new keyframe.

        Returns segment and pixels of the views that had to make room, 0 and 0 where none had to.
        """
        slot = self._recorded[row] % self._views
        oldest = self._segment[row, slot], self._pixels[row, slot].astype(np.int64)
        self._segment[row, slot] = segment
        self._pixels[row, slot] = pixels
        self._recorded[row] += 1
        return oldest

    def forget(self, row: Int32) -> None:
        """Empty these rows."""
        self._segment[row] = NO_SEGMENT
        self._pixels[row] = 0
        self._recorded[row] = 0

    def copy(self, row: Int32, source_row: Int32) -> None:
        """Let ``row`` start with the evidence of ``source_row``."""
        self._segment[row] = self._segment[source_row]
        self._pixels[row] = self._pixels[source_row]
        self._recorded[row] = self._recorded[source_row]

    def renumber(self, number: Int32) -> None:
        """Give every segment the number that ``number`` holds in its place."""
        self._segment = number[self._segment]

    def segments(self, row: Array) -> Int32:
        """Return the segments int32 (N, views) of rows, ``NO_SEGMENT`` where there is no view."""
        return self._segment.take(row, axis=0)

    def showing(self, segment: Bool, among: Bool) -> Int32:
        """Return those of the marked rows (N,), sorted, with a view of a marked segment (S,)."""
        known = self._recorded[: len(among)] > 0
        row = np.flatnonzero(known & among[: len(known)])
        seen = segment.take(self._segment.take(row, axis=0))
        return row.compress(seen.any(axis=1)).astype(np.int32)

    def latest(self, row: Int32) -> tuple[Int32, Int64]:
        """Return segment int32 (N,) and pixels int64 (N,) of the latest view of rows."""
        slot = (self._recorded[row] - 1) % self._views
        return self._segment[row, slot], self._pixels[row, slot].astype(np.int64)

    def entries(self, row: Int32) -> Entries:
        """Return all views of rows."""
        segment, pixels = self.segments(row), self._pixels.take(row, axis=0)
        place, slot = np.nonzero(segment)
        return Entries(place, segment[place, slot], pixels[place, slot].astype(np.int64))
