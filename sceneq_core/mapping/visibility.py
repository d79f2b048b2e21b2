"""What one frame says about the superpoints it shows."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Int32, Int64, UInt16
from sceneq_core.mapping.evidence import NO_SEGMENT


@dataclass(frozen=True, slots=True)
class Sighting:
    """Parallel rows, sorted by superpoint: ``superpoint_id``, dominant ``label`` and ``pixels``.

    ``label`` int32 is the value in the label image, -1 where no segment covers half of it.
    """

    superpoint_id: Int32
    label: Int32
    pixels: Int64


def sight(superpoint_of_point: Int32, label_of_point: UInt16, min_pixels: int) -> Sighting:
    """Return the superpoints with at least ``min_pixels`` and the segment that dominates each."""
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
    return Sighting(enough.astype(np.int32), dominant[enough], total[enough].astype(np.int64))
