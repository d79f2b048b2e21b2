"""Words that compare the targets with each other: nearest, largest, highest."""

from collections.abc import Callable
from dataclasses import dataclass
from math import log

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.reasoning.upright import UprightBox, distance

SMALLEST_EDGE_M = 0.01


@dataclass(frozen=True, slots=True)
class Superlative:
    """What a superlative makes small, and the difference that counts as clear.

    ``measure`` takes target and anchor, or the viewer's place when there is no anchor.
    """

    measure: Callable[[UprightBox, UprightBox], float]
    scale: float


def _log_volume(box: UprightBox) -> float:
    return sum(log(max(edge, SMALLEST_EDGE_M)) for edge in box.size)


SUPERLATIVES: dict[str, Superlative] = {
    "nearest": Superlative(distance, 0.05),
    "farthest": Superlative(lambda target, anchor: -distance(target, anchor), 0.05),
    "largest": Superlative(lambda target, _: -_log_volume(target), 0.1),
    "smallest": Superlative(lambda target, _: _log_volume(target), 0.1),
    "tallest": Superlative(lambda target, _: -float(target.size[2]), 0.05),
    "highest": Superlative(lambda target, _: -float(target.centre[2]), 0.05),
    "lowest": Superlative(lambda target, _: float(target.centre[2]), 0.05),
}
"""Metres, and for sizes the logarithm of the volume: 0.1 is a tenth larger."""

COMPARED_TO_ANCHOR = ("nearest", "farthest")


def probability_of_first(weight: Float64, measure: Float64, scale: float) -> Float64:
    """Return for each target the probability that it is the first real one, (N,).

    ``weight`` (N,) in [0, 1] is the probability that a candidate is a real target at all. One is
    the first when it is real and none of the others is both real and before it, so a doubtful
    candidate that is a little nearer does not beat a certain one. Differences in ``measure`` (N,)
    below ``scale`` decide little: chairs of equal size are all a bit the largest.
    """
    ahead = (measure[:, None] - measure[None, :]) / scale
    before = 1.0 / (1.0 + np.exp(-np.clip(ahead, -50.0, 50.0)))
    np.fill_diagonal(before, 0.0)
    first: Float64 = weight * np.prod(1.0 - before * weight[None, :], axis=1)
    return first
