"""How sure a first guess is, where the softmax says it too boldly or too hesitantly.

J. Platt, "Probabilistic outputs for support vector machines and comparisons to regularized
likelihood methods", 1999, on the log odds of the first guess: what is left goes to all others, in
the proportions they have. Of four sofas to sit on each is meant with a quarter of what there is,
and each is right: the share of right first guesses is no matter of a temperature.
"""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.checks import need_at_least, need_within
from sceneq_core.logistic import sigmoid

STEEPEST = 1e6
CERTAIN = 1e-9
"""Closer to 0 or 1 no probability is taken: it only keeps log odds finite."""


@dataclass(frozen=True, slots=True)
class Sureness:
    """Log odds of the first guess: ``slope`` (>= 0) times what they were, plus ``shift``."""

    slope: float = 1.0
    shift: float = 0.0

    def __post_init__(self) -> None:
        need_at_least(self, 0, "slope")
        need_within(self, -STEEPEST, STEEPEST, "slope", "shift")

    def of(self, p: Float64) -> Float64:
        """Return a distribution (C,) with this sureness, in the same order.

        The first guess stays the first: never less probable than the second becomes.
        """
        if len(p) < 2:
            return p
        first = int(np.argmax(p))
        top = min(max(float(p[first]), CERTAIN), 1.0 - CERTAIN)
        second = float(np.delete(p, first).max())
        sure = float(sigmoid(np.array(self.slope * log_odds(np.array(top)) + self.shift)))
        sure = max(sure, second / (1.0 - top + second))
        changed: Float64 = p * ((1.0 - sure) / (1.0 - top))
        changed[first] = sure
        whole: Float64 = changed / changed.sum()
        return whole


def log_odds(p: Float64) -> Float64:
    """Return log(p / (1 - p)), finite also for 0 and 1."""
    within = np.clip(p, CERTAIN, 1.0 - CERTAIN)
    odds: Float64 = np.log(within) - np.log1p(-within)
    return odds
