"""Which superpoints a frame shows, and which of its 2D segments dominates each."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Int32, Int64, UInt16
from sceneq_core.mapping.evidence import NO_SEGMENT


@dataclass(frozen=True, slots=True)
class Visible:
    """The superpoints in one keyframe, parallel rows sorted by ``superpoint_id`` int32 (S,).

    ``label`` int32 (S,) is the value of the dominant segment in the label image, -1 where no
    segment covers more than half; ``pixels`` int64 (S,) counts the surface points that show it.
    """

    superpoint_id: Int32
    label: Int32
    pixels: Int64


def visible_superpoints(
    superpoint_of_point: Int32, label_of_point: UInt16, min_pixels: int
) -> Visible:
    """Return the superpoints with at least ``min_pixels`` and the segment that dominates each.

    ``superpoint_of_point`` int32 (N,), -1 = none, and ``label_of_point`` uint16 (N,), 0 = none,
    are parallel over the surface points of the keyframe.
    """
    known = superpoint_of_point >= 0
    superpoint, label = superpoint_of_point[known], label_of_point[known].astype(np.int64)
    labels = int(label.max(initial=0)) + 1
    pair, count = np.unique(superpoint * labels + label, return_counts=True)
    pair_superpoint, pair_label = pair // labels, pair % labels
    total = np.bincount(pair_superpoint, count)
    enough = np.flatnonzero(total >= max(min_pixels, 1))
    dominant = np.full(len(total), NO_SEGMENT, np.int32)
    majority = (2 * count > total[pair_superpoint]) & (pair_label > 0)
    dominant[pair_superpoint[majority]] = pair_label[majority]
    return Visible(enough.astype(np.int32), dominant[enough], total[enough].astype(np.int64))
