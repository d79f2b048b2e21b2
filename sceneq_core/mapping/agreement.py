"""Agreement of regions: how often the views that show both give both the same 2D segment."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Array, Float64, Int32, Int64
from sceneq_core.mapping.evidence import NO_SEGMENT


@dataclass(frozen=True, slots=True)
class RegionViews:
    """The segment that dominates each region in each of its top-k views.

    ``segment`` int32 (R + 1, C), ``NO_SEGMENT`` where the view is none of the region's; a column is
    a keyframe, ``column`` int32 (S,) that of each segment number. The last row has no views and
    stands for no region (-1).
    """

    segment: Int32
    column: Int32

    def renumbered(self, kept: Int64, number: Int32) -> "RegionViews":
        """Return the same with only the segments ``kept``, under their new numbers."""
        gone = np.ones(len(number), np.bool_)
        gone[kept] = False
        segment = np.where(gone[self.segment], np.int32(-1), number[self.segment])
        return RegionViews(segment, self.column[kept])

    def dominant(self, region: Array, segment: Array) -> Int32:
        """Return the segment that dominates regions in the keyframes of other segments (N,)."""
        known = (region < len(self.segment) - 1) & (segment < len(self.column))
        row, column = np.where(known, region, -1), self.column[np.where(known, segment, 0)]
        return self.segment[row, column]

    def compare(self, first: Array, second: Array) -> tuple[Int64, Int64]:
        """Return (common views with equal segments, common views), int64 (N,), of region pairs."""
        a, b = self.segment.take(first, axis=0), self.segment.take(second, axis=0)
        common = (a != NO_SEGMENT) & (b != NO_SEGMENT)
        return (common & (a == b)).sum(axis=1), common.sum(axis=1)

    def compare_segments(self, segment: Int32, region: Array) -> tuple[Int64, Int64]:
        """Return the same for the views ``segment`` int32 (N, V) of N things, each with a region.

        ``NO_SEGMENT`` is no view. A region of -1 has no views.
        """
        theirs = self.segment[region[:, None], self.column[segment]]
        common = (segment != NO_SEGMENT) & (theirs != NO_SEGMENT)
        return (common & (theirs == segment)).sum(axis=1), common.sum(axis=1)

    def agree(self, first: Array, second: Array) -> Float64:
        """Return Agree(a, b) of region pairs, float64 (N,), by equation 1 of the paper.

        The share of the common top-k views in which both regions have the same dominant 2D
        segment; 0 where there is no common view.
        """
        same, common = self.compare(first, second)
        return same / np.maximum(common, 1)


def expected_agreement(same: Array, common: Array) -> Float64:
    """Return the agreement to expect of the next view, 0.5 without any evidence.

    Equation 1 as the mean of a Beta(1/2, 1/2) posterior: it tends to Agree(a, b) with the number
    of common views, and one view alone says 0.75 or 0.25, never 1 or 0. So the same threshold is
    right for what was seen twice and for what was seen twenty times.
    """
    return (same + 0.5) / (common + 1.0)
