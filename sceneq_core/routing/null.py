"""The candidate "none of them": one more choice beside the instances, calibrated.

The instances have logits l_i, and p(i) = exp l_i / (exp l_0 + sum exp l_j). The logit of "none" is
l_0 = log sum exp l_j - (bias + weights . evidence), so that p(none) is a logistic function of the
evidence that there is such a thing at all (J. Platt, "Probabilistic outputs for support vector
machines", 1999), and which instance is meant does not depend on it.
"""

from dataclasses import astuple, dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.checks import need_at_least, need_positive, need_within

LEAST, STEEPEST = -1e3, 1e6
"""Limits of evidence and parameters that only keep numbers finite."""
TINY = np.finfo(np.float64).tiny


@dataclass(frozen=True, slots=True)
class Evidence:
    """Logarithms of ratios: no unit, and the same for any number of instances and labels.

    ``name``: p(noun | instance) of the best instance over that of a label picked blindly, 0 = no
    better; ``said``: p that the best one has the colours and the size that are said, 0 = surely;
    ``standing``: p of the likeliest instance over that of one picked blindly, 0 = none stands out.
    """

    name: float
    said: float
    standing: float


NO_EVIDENCE = Evidence(LEAST, LEAST, 0.0)


@dataclass(frozen=True, slots=True)
class NullParams:
    """``temperature`` T of softmax(s / T) that ``name`` and ``said`` are worked out with.

    The weights of the evidence are >= 0: more of it never makes "none" likelier. ``bias``: the
    logit of there being such a thing at evidence 0.
    """

    temperature: float
    name: float
    said: float
    standing: float
    bias: float

    def __post_init__(self) -> None:
        need_positive(self, "temperature")
        need_at_least(self, 0, "name", "said", "standing")
        need_within(self, -STEEPEST, STEEPEST, "name", "said", "standing", "bias")

    def presence(self, evidence: Evidence) -> float:
        """Return 1 - p(none)."""
        weights = np.array([self.name, self.said, self.standing])
        logit = self.bias + float(weights @ np.array(astuple(evidence)))
        return float(0.5 * (1.0 + np.tanh(0.5 * logit)))


def evidence_of(
    log_name: Float64, log_said: Float64, p_max: float, labels: int, instances: int
) -> Evidence:
    """Return the evidence in what is known of the best M instances.

    ``log_name`` (M,) of p(noun | instance) among ``labels``; ``log_said`` (M,) of p of what else
    is said; ``p_max`` of the likeliest of all ``instances``.
    """
    if not len(log_name):
        return NO_EVIDENCE
    best = int(np.argmax(log_name + log_said))
    return Evidence(
        name=max(float(log_name.max()) + float(np.log(labels)), LEAST),
        said=max(float(log_said[best]), LEAST),
        standing=max(float(np.log(max(p_max * instances, TINY))), LEAST),
    )
