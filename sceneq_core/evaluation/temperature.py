"""The temperature that makes probabilities fit what happened.

C. Guo et al., "On Calibration of Modern Neural Networks", ICML 2017, arXiv:1706.04599.
"""

from collections.abc import Callable

import numpy as np

LOWEST, HIGHEST = 0.001, 1.0
"""Cosines lie within -1..1: below, the best takes all; above, all are alike."""

COARSE = 25
TOLERANCE = 1e-4


def fit_temperature(
    loss: Callable[[float], float], lowest: float = LOWEST, highest: float = HIGHEST
) -> float:
    """Return the temperature with the least ``loss``, usually the mean negative log-likelihood.

    A bounded search on a logarithmic scale, between the neighbours of the best of a few evenly
    spread values: with bounded or mixed probabilities the loss may have more than one valley.

    Raises:
        ValueError: bounds that are not 0 < lowest < highest, or a loss that is not finite.
    """
    if not 0 < lowest < highest:
        raise ValueError(f"lowest: expected 0 < lowest < highest, got {lowest} and {highest}")
    grid = np.linspace(np.log(lowest), np.log(highest), COARSE)
    losses = np.array([loss(float(np.exp(log_t))) for log_t in grid])
    if not np.isfinite(losses).all():
        raise ValueError("loss: not finite, there is nothing to fit to")
    from scipy.optimize import minimize_scalar  # slow to import

    best = int(losses.argmin())
    bounds = grid[max(best - 1, 0)], grid[min(best + 1, COARSE - 1)]
    found = minimize_scalar(
        lambda log_t: loss(float(np.exp(log_t))),
        bounds=bounds,
        method="bounded",
        options={"xatol": TOLERANCE},
    )
    refined = found.x if found.fun < losses[best] else grid[best]
    return float(np.exp(refined))
