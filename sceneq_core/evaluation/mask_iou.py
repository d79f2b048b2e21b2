"""How much two labellings of the same points agree, region by region."""

import numpy as np

from sceneq_core.arrays import Float64, Int64


def mask_iou(first: Int64, second: Int64) -> tuple[Float64, Int64, Int64]:
    """Return intersection over union of the regions of ``first`` (N,) and of ``second`` (N,).

    Regions are the points with one id; 0 is no region, but its points count in the size of what
    they belong to otherwise. Returns iou float64 (A, B) and the ids int64 (A,) and (B,), sorted.

    Raises:
        ValueError: the two differ in length.
    """
    if first.shape != second.shape:
        raise ValueError(f"second: {second.shape} ids for {first.shape} points")
    a_ids, a = np.unique(np.append(first, 0), return_inverse=True)
    b_ids, b = np.unique(np.append(second, 0), return_inverse=True)
    cell = a[:-1] * len(b_ids) + b[:-1]
    shared = np.bincount(cell, minlength=len(a_ids) * len(b_ids)).reshape(len(a_ids), len(b_ids))
    either = shared.sum(axis=1, keepdims=True) + shared.sum(axis=0, keepdims=True) - shared
    iou = shared / np.maximum(either, 1)
    rows, columns = a_ids != 0, b_ids != 0
    return iou[np.ix_(rows, columns)], a_ids[rows], b_ids[columns]
