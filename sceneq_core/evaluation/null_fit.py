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


def fit_null(
    evidence_at: Callable[[float], Sequence[Evidence]],
    present: Bool,
    counts: Float64 | None = None,
) -> NullParams:
    """Return the most likely parameters that something is ``present`` (N,).

    ``evidence_at`` returns the evidence in N questions at a temperature; ``counts`` (N,) is how
    much each question counts, ``None`` = all alike.

    Raises:
        ValueError: arrays of different length; all are present or all are absent, so nothing
            tells one from the other.
    """

    def fitted_at(temperature: float) -> tuple[Float64, float]:
        rows = [astuple(one) for one in evidence_at(temperature)]
        evidence = np.array(rows, np.float64).reshape(-1, len(fields(Evidence)))
        return fit_logistic(evidence, present, counts)

    best = fit_temperature(lambda t: fitted_at(t)[1])
    name, said, standing, bias = fitted_at(best)[0].tolist()
    return NullParams(best, name, said, standing, bias)


def fit_logistic(
    evidence: Float64, present: Bool, counts: Float64 | None = None
) -> tuple[Float64, float]:
    """Return weights >= 0 of ``evidence`` (N, K) with the bias after them (K + 1,), and their loss.

    Raises as ``fit_null``.
    """
    if len(evidence) != len(present):
        raise ValueError(f"present: {len(present)} values for {len(evidence)} questions")
    if present.all() or not present.any():
        raise ValueError(f"present: {present.sum()} of {len(present)}, nothing to tell apart")
    weight = np.ones(len(present)) if counts is None else counts
    there, absent = weight[present].sum(), weight[~present].sum()
    target = np.where(present, (there + 1) / (there + 2), 1 / (absent + 2))
    return least_log_loss(evidence, target, counts=weight, nonnegative=True)
