"""One label image from masks that overlap."""

from collections.abc import Iterable

import numpy as np

from sceneq_core.arrays import Bool, UInt16

MOST = np.iinfo(np.uint16).max


def label_image(masks: Iterable[Bool], shape: tuple[int, int], least_px: int = 1) -> UInt16:
    """Return labels uint16 ``shape`` (H, W), 0 = no mask: smaller masks lie over larger ones.

    A handle is then a segment on its mug, and a mug on its table, instead of being hidden below.
    Labels count from 1, the largest mask first; of equal sizes the first lies below. What is left
    of a mask in fewer than ``least_px`` pixels is no segment.
    """
    labels = np.zeros(shape, np.uint16)
    large_first = sorted(masks, key=np.count_nonzero, reverse=True)[:MOST]
    for label, mask in enumerate(large_first, start=1):
        labels[mask] = label
    return compact(labels, least_px)


def compact(labels: UInt16, least_px: int) -> UInt16:
    """Return ``labels`` renumbered 1, 2, ... without those of fewer than ``least_px`` pixels."""
    count = np.bincount(labels.ravel(), minlength=1)
    kept = np.flatnonzero(count >= least_px)
    kept = kept[kept > 0]
    new = np.zeros(len(count), np.uint16)
    new[kept] = np.arange(1, len(kept) + 1)
    return new[labels]
