"""How sure first guesses are, fitted by how often they are right (J. Platt 1999)."""

import numpy as np

from sceneq_core.arrays import Bool, Float64
from sceneq_core.logistic import least_log_loss
from sceneq_core.routing.sureness import Sureness, log_odds


def fit_sureness(p_max: Float64, right: Bool) -> Sureness:
    """Return the most likely sureness of first guesses of ``p_max`` (N,) that are ``right`` (N,).

    On Platt's targets, a little less than certain, so that a few guesses that can all be told apart
    do not make it infinitely sure. Without a right one, or a wrong one, nothing changes.

    Raises:
        ValueError: arrays of different length.
    """
    if len(p_max) != len(right):
        raise ValueError(f"right: {len(right)} values for {len(p_max)} guesses")
    good, bad = int(right.sum()), int((~right).sum())
    if not good or not bad:
        return Sureness()
    target = np.where(right, (good + 1) / (good + 2), 1 / (bad + 2))
    (slope, shift), _ = least_log_loss(log_odds(p_max)[:, None], target, nonnegative=True)
    return Sureness(float(slope), float(shift))
