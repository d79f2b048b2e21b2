"""The two numbers of "none of them", from questions of which it is known whether anything is meant.

J. Platt, "Probabilistic outputs for support vector machines and comparisons to regularized
likelihood methods", 1999: a logistic function by maximum likelihood, on targets that are a little
less than certain, so that a few questions that can all be told apart do not make it infinitely
sure.
"""

import numpy as np

from sceneq_core.arrays import Bool, Float64
from sceneq_core.routing.null import NullParams


def fit_null(evidence: Float64, present: Bool) -> NullParams:
    """Return the most likely parameters for ``evidence`` (N,) that something is ``present`` (N,).

    Raises:
        ValueError: arrays of different length; all are present or all are absent, so nothing
            tells one from the other.
    """
    if len(evidence) != len(present):
        raise ValueError(f"present: {len(present)} values for {len(evidence)} questions")
    there = int(present.sum())
    absent = len(present) - there
    if not there or not absent:
        raise ValueError(f"present: {there} of {len(present)}, nothing to tell apart")
    from scipy.optimize import minimize  # slow to import

    target = np.where(present, (there + 1) / (there + 2), 1 / (absent + 2))

    def loss(x: Float64) -> tuple[float, Float64]:
        scale, bias = x
        logit = bias + scale * evidence
        off = 0.5 * (1.0 + np.tanh(0.5 * logit)) - target
        value = np.logaddexp(0.0, logit) - target * logit
        return float(value.mean()), np.array([(off * evidence).mean(), off.mean()])

    start = np.array([1.0, -float(evidence.mean())])
    best = minimize(loss, start, jac=True, method="L-BFGS-B", bounds=[(0.0, None), (None, None)])
    return NullParams(scale=float(best.x[0]), bias=float(best.x[1]))
