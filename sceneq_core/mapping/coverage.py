"""How many pixels of every 2D segment each region covers, and what follows from it."""

import numpy as np

from sceneq_core.arrays import Array, Bool, Int32, Int64
from sceneq_core.mapping.agreement import RegionViews
from sceneq_core.mapping.evidence import NO_SEGMENT
from sceneq_core.mapping.rows import first_of_runs, largest_of_runs, with_rows
from sceneq_core.mapping.tally import Tally

NO_REGION = -1
_SHIFT = 32
_LOW = (1 << _SHIFT) - 1


class Coverage:
    """The sparse table (region, segment) -> visible pixels, summed over a region's superpoints.

    It has an entry only while a superpoint has evidence of the segment, so the bound of the
    evidence bounds it too. Segments are numbered from 1 in the order of the keyframes, regions
    from 0.

    Attributes:
        segments: one more than the largest segment number.
    """

    def __init__(self, top_views: int, min_pixels: int) -> None:
        self._top_views = top_views
        self._min_pixels = min_pixels
        self._by_region = Tally()
        self._by_segment = Tally()
        self._keyframe = np.zeros(1, np.int32)
        self.segments = 1

    def emptied(self) -> "Coverage":
        """Return a table of the same segments in which nothing is counted."""
        other = Coverage(self._top_views, self._min_pixels)
        other._keyframe, other.segments = self._keyframe, self.segments
        return other

    def open_segments(self, count: int, keyframe: int) -> int:
        """Give numbers to the segments of a keyframe; return the first one."""
        first = self.segments
        self.segments += count
        self._keyframe = with_rows(self._keyframe, self.segments, 0)
        self._keyframe[first : self.segments] = keyframe
        return first

    def renumber(self, kept: Int64, number: Int32) -> None:
        """Keep only the segments ``kept``, sorted; ``number`` holds the new number of each old."""
        self._keyframe, self.segments = self._keyframe[kept], len(kept)
        region, segment = self._by_region.key >> _SHIFT, self._by_region.key & _LOW
        self._by_region.key = region << _SHIFT | number[segment]
        segment, region = self._by_segment.key >> _SHIFT, self._by_segment.key & _LOW
        self._by_segment.key = number[segment].astype(np.int64) << _SHIFT | region

    def add(self, region: Array, segment: Int32, pixels: Int64) -> None:
        """Count pixels, negative ones to take them away; region -1 counts nothing."""
        known = region != NO_REGION
        region, pixels = region[known].astype(np.int64), pixels[known]
        segment = segment[known].astype(np.int64)
        self._by_region.add(region << _SHIFT | segment, pixels)
        self._by_segment.add(segment << _SHIFT | region, pixels)

    def owners(self) -> Int32:
        """Return per segment number the region that covers most of it, or ``NO_REGION``."""
        segment, region = self._by_segment.key >> _SHIFT, self._by_segment.key & _LOW
        row = largest_of_runs(segment, self._by_segment.total)
        owner = np.full(self.segments, NO_REGION, np.int32)
        owner[segment[row]] = region[row]
        return owner

    def region_views(self, regions: int) -> RegionViews:
        """Return the dominant segments of regions 0 to ``regions`` - 1 in their top views.

        A keyframe is a view of a region from ``min_pixels`` on; the ``top_views`` most visible
        ones are kept, later ones first among equals.
        """
        region, segment = self._by_region.key >> _SHIFT, self._by_region.key & _LOW
        keyframes, view = np.unique(self._keyframe[segment], return_inverse=True)
        cell = region * len(keyframes) + view
        row = largest_of_runs(cell, self._by_region.total)
        pixels = _sums_of_runs(cell, self._by_region.total)
        row, pixels = row[pixels >= self._min_pixels], pixels[pixels >= self._min_pixels]
        row = row[_top_of_runs(region[row], pixels, self._top_views)]
        # The last row and column stay empty: for region -1, and for segments of no region.
        table = np.full((regions + 1, len(keyframes) + 1), NO_SEGMENT, np.int32)
        table[region[row], view[row]] = segment[row]
        column = np.full(self.segments, len(keyframes), np.int32)
        column[segment] = view
        return RegionViews(table, column)

    def differing(self, views: RegionViews, other: RegionViews) -> Bool:
        """Mark the segments (S,) of regions whose view of them is not the same in both tables."""
        region, segment = self._by_region.key >> _SHIFT, self._by_region.key & _LOW
        mark = np.zeros(self.segments, np.bool_)
        differs = views.dominant(region, segment) != other.dominant(region, segment)
        mark[segment[differs]] = True
        return mark


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
