"""The dominant segments of all regions, of which only the rows that changed are written anew."""

import numpy as np

from sceneq_core.arrays import Bool, Int32, Int64
from sceneq_core.mapping.agreement import RegionViews
from sceneq_core.mapping.evidence import NO_SEGMENT
from sceneq_core.mapping.rows import first_of_runs, with_rows

NO_COLUMN = 0
_FEWEST = 64
"""Columns below which none are looked for that could be given again."""


class RegionTable:
    """Region by keyframe -> segment; a keyframe has a column from 1 while it is a view of any.

    Remembers how the rows were when ``decide`` was last called, for ``differing``.
    """

    def __init__(self, top_views: int) -> None:
        self._segment = np.full((1, 1), NO_SEGMENT, np.int32)
        self._top = np.full((1, top_views), NO_SEGMENT, np.int32)
        self._columns = 1
        self._before: dict[int, Int32] = {}

    def views(self, regions: int, column: Int32) -> RegionViews:
        """Return the rows of regions 0 to ``regions`` - 1; ``column`` is that of each segment."""
        self._reserve(regions + 1)
        rows, columns = slice(regions + 1), slice(self._columns)
        return RegionViews(self._segment[rows, columns], column, self._top[rows])

    def take_columns(self, count: int) -> Int32:
        """Give ``count`` columns to keyframes that had none."""
        first, self._columns = self._columns, self._columns + count
        if self._columns > self._segment.shape[1]:
            shape = len(self._segment), 2 * self._columns
            wider = np.full(shape, NO_SEGMENT, np.int32)
            wider[:, :first] = self._segment[:, :first]
            self._segment = wider
        return np.arange(first, self._columns, dtype=np.int32)

    def remember(self, region: Int64) -> None:
        """Note how regions are, before they are written the first time since ``decide``."""
        self._reserve(int(region.max(initial=-1)) + 2)
        for number in region.tolist():
            if number not in self._before:
                self._before[number] = self._segment[number, : self._columns].copy()

    def put(self, changed: Int64, region: Int64, column: Int32, segment: Int32) -> None:
        """Let each ``changed`` region have the views that parallel rows, sorted, say it has."""
        self._reserve(int(changed.max(initial=-1)) + 2)
        self._segment[changed] = NO_SEGMENT
        self._segment[region, column] = segment
        start = first_of_runs(region)
        place = np.arange(len(region)) - np.repeat(start, np.diff(start, append=len(region)))
        self._top[changed] = NO_SEGMENT
        self._top[region, place] = segment

    def decide(self) -> None:
        """Compare with how the table is now from here on."""
        self._before.clear()

    def differing(self) -> tuple[Int64, Bool]:
        """Return the regions (R,), sorted, that were written, and which views (R, C) differ."""
        region = np.array(sorted(self._before), np.int64)
        before = np.full((len(region), self._columns), NO_SEGMENT, np.int32)
        for row, number in zip(before, region.tolist(), strict=True):
            row[: len(self._before[number])] = self._before[number]
        return region, before != self._segment[region, : self._columns]

    def pack(self, column: Int32) -> Int32:
        """Give up the columns that none of ``column`` (N,) is; return the new number of each.

        While there are many in use, or how rows were is still asked for, all stay as they are.
        """
        number = np.arange(self._columns, dtype=np.int32)
        used = np.zeros(self._columns, np.bool_)
        used[column], used[NO_COLUMN] = True, True
        kept = np.flatnonzero(used)
        if self._before or self._columns <= max(_FEWEST, 2 * len(kept)):
            return number
        self._segment = np.ascontiguousarray(self._segment[:, kept])
        self._columns = len(kept)
        return np.where(used, np.cumsum(used) - 1, NO_COLUMN).astype(np.int32)

    def renumber(self, kept: Int64, number: Int32) -> None:
        """Keep only the segments ``kept``; ``number`` holds the new number of each old one."""
        gone = np.ones(len(number), np.bool_)
        gone[kept] = False
        self._segment, self._top = number[self._segment], number[self._top]
        self._before = {
            region: np.where(gone[row], np.int32(-1), number[row])
            for region, row in self._before.items()
        }

    def _reserve(self, count: int) -> None:
        """Make room for ``count`` rows, the last of which stays empty."""
        self._segment = with_rows(self._segment, count, NO_SEGMENT)
        self._top = with_rows(self._top, count, NO_SEGMENT)
