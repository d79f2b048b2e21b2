"""How many pixels of every 2D segment each region covers, and what follows from it."""

import numpy as np

from sceneq_core.arrays import Array, Bool, Int32, Int64
from sceneq_core.mapping.agreement import RegionViews
from sceneq_core.mapping.region_table import NO_COLUMN, RegionTable
from sceneq_core.mapping.rows import first_of_runs, largest_of_runs, marked, sorted_keys, with_rows
from sceneq_core.mapping.tally import Tally

NO_REGION = -1
_SHIFT = 32
_LOW = (1 << _SHIFT) - 1


class Coverage:
    """The sparse table (region, segment) -> visible pixels, summed over a region's superpoints.

    It has an entry only while a superpoint has evidence of the segment, so the bound of the
    evidence bounds it too. Segments are numbered from 1 in the order of the keyframes, regions
    from 0. What follows from it is worked out again only for what changed.

    Attributes:
        segments: one more than the largest segment number.
    """

    def __init__(self, top_views: int, min_pixels: int) -> None:
        self._top_views = top_views
        self._min_pixels = min_pixels
        self._by_region = Tally()
        self._by_segment = Tally()
        self._keyframe = np.zeros(1, np.int32)
        self._owner = np.full(1, NO_REGION, np.int32)
        self._column = np.full(1, NO_COLUMN, np.int32)
        self._table = RegionTable(top_views)
        self._changed: list[Int64] = []
        self.segments = 1

    def open_segments(self, count: int, keyframe: int) -> int:
        """Give numbers to the segments of a keyframe; return the first one."""
        first = self.segments
        self.segments += count
        self._keyframe = with_rows(self._keyframe, self.segments, 0)
        self._keyframe[first : self.segments] = keyframe
        return first

    def renumber(self, kept: Int64, number: Int32) -> None:
        """Keep only the segments ``kept``, sorted; ``number`` holds the new number of each old."""
        self._follow()
        self._keyframe, self.segments = self._keyframe[kept], len(kept)
        self._owner, self._column = self._owner[kept], self._column[kept]
        self._table.renumber(kept, number)
        region, segment = self._by_region.key >> _SHIFT, self._by_region.key & _LOW
        self._by_region.key = region << _SHIFT | number[segment]
        segment, region = self._by_segment.key >> _SHIFT, self._by_segment.key & _LOW
        self._by_segment.key = number[segment].astype(np.int64) << _SHIFT | region

    def add(self, region: Array, segment: Int32, pixels: Int64) -> None:
        """Count pixels, negative ones to take them away; region -1 counts nothing."""
        known = np.flatnonzero(region != NO_REGION)
        region, pixels = region.take(known).astype(np.int64), pixels.take(known)
        segment = segment.take(known).astype(np.int64)
        key = region << _SHIFT | segment
        self._by_region.add(key, pixels)
        self._by_segment.add(segment << _SHIFT | region, pixels)
        self._changed.append(sorted_keys(key))

    def owners(self) -> Int32:
        """Return per segment number the region that covers most of it, or ``NO_REGION``."""
        self._follow()
        return self._owner

    def region_views(self, regions: int) -> RegionViews:
        """Return the dominant segments of regions 0 to ``regions`` - 1 in their top views.

        A keyframe is a view of a region from ``min_pixels`` on; the ``top_views`` most visible
        ones are kept, later ones first among equals. It holds until something is added.
        """
        self._follow()
        column = np.where(self._owner == NO_REGION, NO_COLUMN, self._column)
        return self._table.views(regions, column)

    def views_of(self, region: Int64, segment: Int32, pixels: Int64, regions: int) -> RegionViews:
        """Return the same of other regions, 0 to ``regions`` - 1, which cover these pixels."""
        alone = Tally()
        alone.add(region << _SHIFT | segment, pixels)
        covered = alone.key & _LOW
        keyframe, place = np.unique(self._keyframe[covered], return_inverse=True)
        column = np.full(self.segments, NO_COLUMN, np.int32)
        table = RegionTable(self._top_views)
        column[covered] = table.take_columns(len(keyframe))[place]
        everyone = np.arange(regions)
        table.put(everyone, *self._dominant(alone.key, alone.total, column))
        return table.views(regions, column)

    def covering(self, segment: Bool, regions: int) -> Bool:
        """Mark the regions (R + 1,) that cover something of marked segments (S,).

        The last one is marked too: nobody knows what is seen of what is in no region (-1).
        """
        entry = self._by_segment.under(np.flatnonzero(segment), _SHIFT)
        return marked(np.append(self._by_segment.key.take(entry) & _LOW, regions), regions + 1)

    def decide(self) -> None:
        """Let ``differing`` compare with what holds now."""
        self._follow()
        self._table.decide()

    def differing(self) -> Bool:
        """Mark the segments (S,) of regions whose view of them is another than at ``decide``."""
        self._follow()
        mark = np.zeros(self.segments, np.bool_)
        region, differs = self._table.differing()
        key = self._by_region.key.take(self._by_region.under(region, _SHIFT))
        row, segment = np.searchsorted(region, key >> _SHIFT), key & _LOW
        mark[segment[differs[row, self._column[segment]]]] = True
        return mark

    def _follow(self) -> None:
        """Work out owners and views where pixels were added since the last time."""
        if len(self._owner) < self.segments:
            new = np.zeros(self.segments - len(self._owner), np.int32)
            self._owner = np.concatenate((self._owner, new + np.int32(NO_REGION)))
            self._column = np.concatenate((self._column, new + np.int32(NO_COLUMN)))
        if self._changed:
            key, self._changed = sorted_keys(*self._changed), []
            segment = sorted_keys(key & _LOW)
            self._own(segment)
            self._open_columns(segment)
            region = key >> _SHIFT
            self._view(region.take(first_of_runs(region)))

    def _own(self, changed: Int64) -> None:
        """Find the owners of segments."""
        row = self._by_segment.under(changed, _SHIFT)
        key = self._by_segment.key.take(row)
        segment, region = key >> _SHIFT, key & _LOW
        largest = largest_of_runs(segment, self._by_segment.total.take(row))
        self._owner = self._owner.copy()  # somebody may hold the owners so far
        self._owner[changed] = NO_REGION
        self._owner[segment[largest]] = region[largest]

    def _open_columns(self, changed: Int64) -> None:
        """Give the keyframes of segments that are owned now their columns."""
        owned = np.flatnonzero(self._owner != NO_REGION)
        self._column = self._table.pack(self._column[owned])[self._column]
        owned = changed[self._owner[changed] != NO_REGION]
        bare = owned[self._column[owned] == NO_COLUMN]
        if len(bare):
            keyframe = np.unique(self._keyframe[bare])
            column = self._table.take_columns(len(keyframe))
            of_segment = self._keyframe[: self.segments]
            place = np.searchsorted(keyframe, of_segment).clip(max=len(keyframe) - 1)
            same = np.flatnonzero(keyframe[place] == of_segment)
            self._column[same] = column[place[same]]

    def _view(self, changed: Int64) -> None:
        """Find the dominant segments of regions."""
        entry = self._by_region.under(changed, _SHIFT)
        key, total = self._by_region.key.take(entry), self._by_region.total.take(entry)
        self._table.remember(changed)
        self._table.put(changed, *self._dominant(key, total, self._column))

    def _dominant(self, key: Int64, total: Int64, column: Int32) -> tuple[Int64, Int32, Int32]:
        """Return region, column and segment of the top views of regions, parallel and sorted.

        ``key`` int64 (N,) are packed regions and segments, sorted, with ``total`` pixels each.
        """
        region, segment = key >> _SHIFT, key & _LOW
        of_key = column.take(segment)
        cell = region << _SHIFT | of_key
        row, pixels = largest_of_runs(cell, total), _sums_of_runs(cell, total)
        row, pixels = row[pixels >= self._min_pixels], pixels[pixels >= self._min_pixels]
        row = row[_top_of_runs(region[row], pixels, self._top_views)]
        return region[row], of_key[row], segment[row].astype(np.int32)


def _sums_of_runs(key: Int64, size: Int64) -> Int64:
    start = first_of_runs(key)
    return np.add.reduceat(size, start) if len(start) else np.zeros(0, np.int64)


def _top_of_runs(key: Int64, size: Int64, count: int) -> Int64:
    """Return the rows, sorted, of the ``count`` largest of each run, later ones among equals."""
    start = first_of_runs(key)
    length = np.diff(start, append=len(key))
    if length.max(initial=0) <= count:
        return np.arange(len(key))
    order = np.lexsort((-np.arange(len(key)), -size, key))
    rank = np.arange(len(key)) - np.repeat(start, length)
    return np.sort(order[rank < count])
