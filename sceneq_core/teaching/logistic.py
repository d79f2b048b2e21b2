"""Evidence to probability: p = 1 / (1 + exp(-(w . x + b)))."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64
from sceneq_core.logistic import least_log_loss, sigmoid

_RIDGE = 1e-6
"""Keeps the weights finite when the pairs can be told apart without error."""


@dataclass(frozen=True, slots=True)
class Logistic:
    """``weights`` w (one for each measure) and ``bias`` b."""

    weights: tuple[float, ...]
    bias: float

    def __post_init__(self) -> None:
        if not self.weights or not np.isfinite([*self.weights, self.bias]).all():
            raise ValueError(f"weights: {self.weights}, bias {self.bias}: not finite numbers")

    def p(self, measures: Float64) -> Float64:
        """Return the probability (N,) of each row of ``measures`` (N, M)."""
        score = np.asarray(measures, np.float64) @ np.array(self.weights) + self.bias
        return sigmoid(score)


def fit_logistic(measures: Float64, is_true: Bool) -> Logistic:
    """Return the logistic of least mean log loss on ``measures`` (N, M).

    Raises:
        ValueError: all pairs are of one kind: nothing to tell apart.
    """

    if not 0 < is_true.sum() < len(is_true):
        raise ValueError(f"pairs: {int(is_true.sum())} of {len(is_true)} are the same")
    w, _ = least_log_loss(measures, is_true.astype(np.float64), ridge=_RIDGE)
    return Logistic(tuple(float(v) for v in w[:-1]), float(w[-1]))
