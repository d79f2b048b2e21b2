"""Does a probability mean what it says? Bins of confidence against the share that was right.

C. Guo et al., "On Calibration of Modern Neural Networks", ICML 2017, arXiv:1706.04599;
bins of equal mass: M. P. Naeini et al., AAAI 2015 (and J. Nixon et al., arXiv:1904.01685).
"""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int64


@dataclass(frozen=True, slots=True)
class Bin:
    """Predictions with a confidence in (``low``, ``high``]: how many, how sure, how often right."""

    low: float
    high: float
    count: int
    confidence: float
    accuracy: float


def equal_width_bins(confidence: Float64, right: Bool, count: int) -> tuple[Bin, ...]:
    """Return the bins that hold anything of ``count`` equally wide ones over (0, 1].

    ``confidence`` (N,) in 0..1 and ``right`` (N,). A confidence of 0 belongs to the first bin.

    Raises:
        ValueError: arrays of different length, values outside 0..1, or no bin at all.
    """
    _check(confidence, right, count)
    of_each = np.clip(np.ceil(confidence * count).astype(np.int64) - 1, 0, count - 1)
    edges = np.arange(count + 1) / count
    return _bins(confidence, right, of_each, edges)


def equal_mass_bins(confidence: Float64, right: Bool, count: int) -> tuple[Bin, ...]:
    """Return at most ``count`` bins that hold equally many predictions, as far as ties allow.

    Equal confidences share a bin, so the result does not depend on the order of the predictions.
    Arguments and errors as ``equal_width_bins``.
    """
    _check(confidence, right, count)
    if not len(confidence):
        return ()
    parts = np.array_split(np.sort(confidence), min(count, len(confidence)))
    upper = np.unique([part[-1] for part in parts])
    of_each = np.searchsorted(upper, confidence, side="left")
    return _bins(confidence, right, of_each, np.concatenate(([0.0], upper)))


def calibration_error(bins: tuple[Bin, ...]) -> float:
    """Return the expected calibration error: mean |accuracy - confidence|, weighted by count."""
    total = sum(one.count for one in bins)
    gaps = (one.count * abs(one.accuracy - one.confidence) for one in bins)
    return sum(gaps) / total if total else 0.0


def _bins(confidence: Float64, right: Bool, of_each: Int64, edges: Float64) -> tuple[Bin, ...]:
    made = []
    for at in np.unique(of_each).tolist():
        inside = of_each == at
        made.append(
            Bin(
                low=float(edges[at]),
                high=float(edges[at + 1]),
                count=int(inside.sum()),
                confidence=float(confidence[inside].mean()),
                accuracy=float(right[inside].mean()),
            )
        )
    return tuple(made)


def _check(confidence: Float64, right: Bool, count: int) -> None:
    if len(confidence) != len(right):
        raise ValueError(f"right: {len(right)} values for {len(confidence)} confidences")
    if count < 1:
        raise ValueError(f"count: {count} bins, expected 1 or more")
    if len(confidence) and not (confidence.min() >= 0 and confidence.max() <= 1):
        raise ValueError(f"confidence: {confidence.min()}..{confidence.max()} is outside 0..1")
