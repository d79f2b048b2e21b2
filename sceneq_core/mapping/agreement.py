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
    stands for no region (-1). ``top`` int32 (R + 1, V) are the segments of each row by themselves,
    in no more columns than a region has views.
    """

    segment: Int32
    column: Int32
    top: Int32

    def compare(self, first: Array, second: Array) -> tuple[Int64, Int64]:
        """Return (common views with equal segments, common views), int64 (N,), of region pairs."""
        return self.compare_segments(self.top.take(first, axis=0), second)

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
