"""Which keyframes show an instance best: much of it, whole, and from different sides."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int64
from sceneq_core.checks import need_positive, need_within
from sceneq_core.vectors import unit_rows


@dataclass(frozen=True, slots=True)
class ChoiceParams:
    """How views are ranked.

    Attributes:
        count: views kept per instance (top-k).
        min_visible_px: full-resolution pixels below which no crop says what it shows.
        cut_weight: what a pixel counts for when the image border cuts the instance.
        repeat_weight: what a pixel counts for when a better view has nearly the same direction.
        distinct_deg: viewing directions further apart than this are different sides.
    """

    count: int = 5
    min_visible_px: int = 64
    cut_weight: float = 0.5
    repeat_weight: float = 0.5
    distinct_deg: float = 15.0

    def __post_init__(self) -> None:
        need_positive(self, "count", "min_visible_px", "cut_weight")
        need_positive(self, "repeat_weight", "distinct_deg")
        need_within(self, 0, 1, "cut_weight", "repeat_weight")


@dataclass(frozen=True, slots=True)
class Candidates:
    """Keyframes that show one instance, oldest first (M rows).

    ``visible_px`` (M,) full-resolution pixels; ``cut`` (M,) whether the border cuts it;
    ``camera_world`` (M, 3) metres.
    """

    visible_px: Int64
    cut: Bool
    camera_world: Float64


def choose(candidates: Candidates, centre_world: Float64, params: ChoiceParams) -> list[int]:
    """Return the rows of the best views of an instance at ``centre_world`` (3,), best first.

    Greedy: each next view is the one with the highest score beside those already chosen. Of equal
    scores the older row wins, so the result depends on nothing but the arguments.
    """
    enough = candidates.visible_px >= params.min_visible_px
    score = np.where(enough, candidates.visible_px.astype(np.float64), 0.0)
    score[candidates.cut] *= params.cut_weight
    direction = unit_rows(candidates.camera_world - centre_world)
    same_side = direction @ direction.T > np.cos(np.radians(params.distinct_deg))
    repeat = np.ones(len(score))
    chosen: list[int] = []
    for _ in range(min(params.count, int(enough.sum()))):
        best = int(np.argmax(score * repeat))
        chosen.append(best)
        score[best] = 0.0
        repeat[same_side[best]] = params.repeat_weight
    return chosen
