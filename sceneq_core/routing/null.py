"""The candidate "none of them": one more candidate beside the instances, whose logit is calibrated.

The instances have logits l_i, and p(i) = exp l_i / (exp l_0 + sum exp l_j). The logit of "none" is
l_0 = log sum exp l_j - (bias + scale * evidence), so that p(none) is a logistic function of the
evidence that there is such a thing at all (J. Platt, "Probabilistic outputs for support vector
machines", 1999), and which instance is meant does not depend on it.
"""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.checks import need_at_least, need_within

LEAST, STEEPEST = -1e3, 1e6
"""Limits of evidence and parameters that only keep numbers finite."""


@dataclass(frozen=True, slots=True)
class NullParams:
    """``scale`` >= 0: more evidence never makes "none" likelier; ``bias``: at evidence 0."""

    scale: float
    bias: float

    def __post_init__(self) -> None:
        need_at_least(self, 0, "scale")
        need_within(self, -STEEPEST, STEEPEST, "scale", "bias")

    def presence(self, evidence: float) -> float:
        """Return 1 - p(none)."""
        return float(0.5 * (1.0 + np.tanh(0.5 * (self.bias + self.scale * evidence))))


def evidence(log_p: Float64, choices: int) -> float:
    """Return the evidence in log p(words | instance) (M,) of the best instances.

    The logarithm of how many of them are called so, as the encoder has it, in units of what a
    label picked blindly among ``choices`` would make one of them: 0 = as good as picked blindly.
    """
    called_so = float(np.logaddexp.reduce(log_p)) if len(log_p) else LEAST
    return max(called_so + float(np.log(choices)), LEAST)
