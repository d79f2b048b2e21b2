"""The numbers of "none of them", from questions of which it is known whether anything is meant.

J. Platt, "Probabilistic outputs for support vector machines and comparisons to regularized
likelihood methods", 1999: a logistic function by maximum likelihood, on targets that are a little
less than certain, so that a few questions that can all be told apart do not make it infinitely
sure.
"""

from collections.abc import Callable, Sequence
from dataclasses import astuple, fields

import numpy as np

from sceneq_core.arrays import Bool, Float64
from sceneq_core.evaluation.temperature import fit_temperature
from sceneq_core.logistic import least_log_loss
from sceneq_core.routing.null import Evidence, NullParams


def fit_null(evidence_at: Callable[[float], Sequence[Evidence]], present: Bool) -> NullParams:
    """Return the most likely parameters that something is ``present`` (N,).

    ``evidence_at`` returns the evidence in N questions at a temperature.

    Raises:
        ValueError: arrays of different length; all are present or all are absent, so nothing
            tells one from the other.
    """

    def fitted_at(temperature: float) -> tuple[Float64, float]:
        rows = [astuple(one) for one in evidence_at(temperature)]
        return fit_logistic(np.array(rows, np.float64).reshape(-1, len(fields(Evidence))), present)

    best = fit_temperature(lambda t: fitted_at(t)[1])
    name, said, standing, bias = fitted_at(best)[0].tolist()
    return NullParams(best, name, said, standing, bias)


def fit_logistic(evidence: Float64, present: Bool) -> tuple[Float64, float]:
    """Return weights >= 0 of ``evidence`` (N, K) with the bias after them (K + 1,), and their loss.

    Raises as ``fit_null``.
    """
    if len(evidence) != len(present):
        raise ValueError(f"present: {len(present)} values for {len(evidence)} questions")
    there = int(present.sum())
    absent = len(present) - there
    if not there or not absent:
        raise ValueError(f"present: {there} of {len(present)}, nothing to tell apart")
    target = np.where(present, (there + 1) / (there + 2), 1 / (absent + 2))
    return least_log_loss(evidence, target, nonnegative=True)
