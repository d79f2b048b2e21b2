"""Scores that only the true probabilities minimise.

Where several answers are right, they count as one class: what matters is that one of them is
meant, not how the probability is spread among them.
"""

import numpy as np

from sceneq_core.arrays import Bool, Float64

LEAST_P = 1e-12
"""A smaller probability costs no more, so that one impossible answer does not hide all others."""


def log_loss(p: Float64, is_right: Bool) -> float:
    """Return -log of the probability, in ``p`` (C,), of the classes marked in ``is_right`` (C,)."""
    return -float(np.log(max(float(p[is_right].sum()), LEAST_P)))


def brier(p: Float64, is_right: Bool) -> float:
    """Return the Brier score over the classes, 0 to 2: squared distance of ``p`` to the truth.

    G. W. Brier, Monthly Weather Review 78 (1950). The right classes (C,) count as one.
    """
    missed, wrong = 1.0 - float(p[is_right].sum()), p[~is_right]
    return missed * missed + float((wrong * wrong).sum())


def top_brier(confidence: Float64, right: Bool) -> float:
    """Return the mean squared difference of ``confidence`` (N,) and being ``right`` (N,), 0 to 1.

    The Brier score of the first guess alone; 0 without any.
    """
    return float(((confidence - right) ** 2).mean()) if len(confidence) else 0.0
