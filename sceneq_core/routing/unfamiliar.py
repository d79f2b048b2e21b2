"""How sure to be in rooms whose things look unlike what the encoder was taught with.

An encoder is right more often about furniture it was taught with than about any other, at the same
cosines: no single calibration is true of both. So there are two, and how familiar a scene looks
says how much each of them counts.
"""

from dataclasses import dataclass

import numpy as np

from sceneq_core.checks import need_positive, need_within
from sceneq_core.logistic import sigmoid
from sceneq_core.mapping.delta import OBJECT
from sceneq_core.routing.columns import Columns
from sceneq_core.routing.null import NullParams
from sceneq_core.routing.sureness import Sureness

MOST_FAMILIAR = 0.1
"""Of the instances in a scene, those that look most like what was taught. Many of the others are
parts of things or seen badly, and look strange in every room."""
STEEPEST = 1e6


@dataclass(frozen=True, slots=True)
class Unfamiliar:
    """What a router has for familiar scenes, fitted in unfamiliar ones.

    ``middle`` is the familiarity (a cosine) at which a scene is as likely either; ``slope`` (>= 0)
    how fast the log odds of being familiar grow with it.
    """

    temperature: float
    middle: float
    slope: float
    null: NullParams | None = None
    null_described: NullParams | None = None
    sureness_described: Sureness | None = None

    def __post_init__(self) -> None:
        need_positive(self, "temperature")
        need_within(self, -1, 1, "middle")
        need_within(self, 0, STEEPEST, "slope")

    def share(self, familiarity: float) -> float:
        """Return how probably a scene of this familiarity is unfamiliar."""
        return float(sigmoid(np.array(self.slope * (self.middle - familiarity))))


def scene_familiarity(columns: Columns) -> float:
    """Return how familiar the most familiar objects look on average; 1 in a scene without any."""
    seen = columns.familiarity[columns.role == OBJECT]
    if not len(seen):
        return 1.0
    best = np.sort(seen)[-int(np.ceil(MOST_FAMILIAR * len(seen))) :]
    return float(best.mean())
