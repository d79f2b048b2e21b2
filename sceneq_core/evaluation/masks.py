"""Predicted instances of one scene as sets of evaluation points."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Array, Float64, Int64


@dataclass(frozen=True, slots=True, eq=False)
class PredictedMasks:
    """P predicted instances over numbered points; masks may overlap.

    Attributes:
        mask: int64 (M,) number of the mask, 0 to P - 1, of each (mask, point) pair.
        point: int64 (M,) the point of the pair; no pair stands there twice.
        label: int64 (P,) class number of every mask.
        score: float64 (P,) confidence; only its order counts.

    Raises:
        ValueError: columns of different lengths, a mask number out of range or a NaN score.
    """

    mask: Int64
    point: Int64
    label: Int64
    score: Float64

    def __post_init__(self) -> None:
        if self.mask.shape != self.point.shape or self.label.shape != self.score.shape:
            raise ValueError("masks: columns of different lengths")
        if len(self.mask) and not 0 <= self.mask.min() <= self.mask.max() < len(self.label):
            raise ValueError(f"mask: expected 0 to {len(self.label) - 1}, got {self.mask.max()}")
        if np.isnan(self.score).any():
            raise ValueError("score: not a number")

    def __len__(self) -> int:
        return len(self.label)

    @property
    def size(self) -> Int64:
        """Points of every mask, int64 (P,)."""
        return np.bincount(self.mask, minlength=len(self))


def disjoint_masks(instance_id: Array, ids: Int64, label: Int64, score: Float64) -> PredictedMasks:
    """Return the masks of a cloud in which every point belongs to one instance at most.

    Args:
        instance_id: integers (N,) per point; values that are not in ``ids`` belong to no mask.
        ids: int64 (P,) distinct instance ids, in the order in which the masks shall stand.
        label: int64 (P,) class number of every instance.
        score: float64 (P,) confidence of every instance.
    """
    if not len(ids):
        return PredictedMasks(np.zeros(0, np.int64), np.zeros(0, np.int64), label, score)
    order = np.argsort(ids)
    place = np.clip(np.searchsorted(ids, instance_id, sorter=order), 0, len(ids) - 1)
    mask = order[place]
    point = np.flatnonzero(ids[mask] == instance_id)
    return PredictedMasks(mask[point], point, label, score)
