"""Logistic regression: p = 1 / (1 + exp(-(w . x + b))) of least log loss."""

import numpy as np

from sceneq_core.arrays import Float64


def sigmoid(logit: Float64) -> Float64:
    """Return 1 / (1 + exp(-logit)), which neither overflows nor warns."""
    p: Float64 = 0.5 * (1.0 + np.tanh(0.5 * logit))
    return p


def least_log_loss(
    evidence: Float64,
    target: Float64,
    *,
    counts: Float64 | None = None,
    nonnegative: bool = False,
    ridge: float = 0.0,
) -> tuple[Float64, float]:
    """Return the weights of ``evidence`` (N, K) with the bias after them (K + 1,), and their loss.

    ``target`` float64 (N,) in [0, 1]; ``counts`` (N,) is how much each counts, ``None`` = all
    alike. ``nonnegative``: no weight is below 0, the bias may be; ``ridge`` times half the square
    of all of them is added to the mean log loss.
    """
    from scipy.optimize import minimize  # slow to import

    columns = np.column_stack([evidence, np.ones(len(evidence))])
    kinds = columns.shape[1] - 1
    share = np.ones(len(target)) if counts is None else counts
    share = share / share.sum()

    def loss(w: Float64) -> tuple[float, Float64]:
        logit = columns @ w
        value = share @ (np.logaddexp(0.0, logit) - target * logit) + 0.5 * ridge * w @ w
        slope = columns.T @ (share * (sigmoid(logit) - target)) + ridge * w
        return float(value), slope

    bounds = [(0.0, None)] * kinds + [(None, None)] if nonnegative else None
    best = minimize(loss, np.zeros(kinds + 1), jac=True, bounds=bounds)
    return best.x, float(best.fun)
