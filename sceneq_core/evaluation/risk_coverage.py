"""How often is wrong what is answered, when only the surest are answered?

Y. Geifman and R. El-Yaniv, "Selective Classification for Deep Neural Networks", NeurIPS 2017,
arXiv:1705.08500; excess area: Y. Geifman et al., ICLR 2019, arXiv:1805.08206.
"""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64


@dataclass(frozen=True, slots=True, eq=False)
class RiskCoverage:
    """The curve: share of wrong ones, ``risk`` (N,), among the surest ``coverage`` (N,) = i / N."""

    coverage: Float64
    risk: Float64

    @property
    def area(self) -> float:
        """The area under the curve (AURC): mean of the risk over all coverages; 0 when empty."""
        return float(self.risk.mean()) if len(self.risk) else 0.0

    @property
    def least_area(self) -> float:
        """The area that the best order of the same answers would have, all right ones first."""
        wrong = round(float(self.risk[-1]) * len(self.risk)) if len(self.risk) else 0
        order = np.arange(len(self.risk), 0, -1)
        return risk_coverage(order.astype(np.float64), order > wrong).area

    @property
    def excess_area(self) -> float:
        """How much larger the area is than the least possible: the fault of the confidence."""
        return self.area - self.least_area


def risk_coverage(confidence: Float64, right: Bool) -> RiskCoverage:
    """Return the curve of predictions with ``confidence`` (N,), ``right`` (N,) or not.

    Of equally sure ones nobody knows the order: each counts as the mean of them, which is what a
    random order gives on average.

    Raises:
        ValueError: arrays of different length.
    """
    if len(confidence) != len(right):
        raise ValueError(f"right: {len(right)} values for {len(confidence)} confidences")
    wrong, number = _wrong_in_order(confidence, right), np.arange(1, len(right) + 1)
    return RiskCoverage(number / max(len(right), 1), np.cumsum(wrong) / number)


def _wrong_in_order(confidence: Float64, right: Bool) -> Float64:
    """Return the chance to be wrong (N,) of the surest, the next ..."""
    _, tie, size = np.unique(-confidence, return_inverse=True, return_counts=True)
    wrong: Float64 = np.bincount(tie, weights=~right, minlength=len(size)) / size
    return np.repeat(wrong, size)
