"""How probable a name of an instance may be at most, by how familiar the instance looks.

A softmax over names knows nothing of things that have none of them: of what looks like nothing the
encoder was taught with, the surest names are wrong as often as not.
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from sceneq_core.checks import need_at_least, need_within
from sceneq_core.logistic import sigmoid

STEEPEST = 1e6
STRANGE = -1.0
"""The familiarity of what nothing is known of."""


@runtime_checkable
class HasCeiling(Protocol):
    """An encoder whose names may be surer, the more familiar a thing looks."""

    def ceiling_at(self, familiarity: float) -> float:
        """Return the highest probability of a name at this familiarity."""


@dataclass(frozen=True, slots=True)
class LabelCeiling:
    """The share of first names that are right, a logistic function of the familiarity.

    Its log odds are ``slope`` (>= 0) times the familiarity plus ``shift``.
    """

    slope: float
    shift: float

    def __post_init__(self) -> None:
        need_at_least(self, 0, "slope")
        need_within(self, -STEEPEST, STEEPEST, "slope", "shift")

    def at(self, familiarity: float) -> float:
        """Return the share that is right at this familiarity."""
        return float(sigmoid(np.array(self.slope * familiarity + self.shift)))
