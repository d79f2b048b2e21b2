"""Words that compare the targets with each other: nearest, largest, highest."""

from collections.abc import Callable
from dataclasses import dataclass
from math import log
from typing import Any

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.reasoning.upright import UprightBox, distance

SMALLEST_EDGE_M = 0.01


@dataclass(frozen=True, slots=True)
class Superlative:
    """What a superlative makes small, and the difference that counts as clear.

    ``measure`` takes target and anchor, or the viewer's place when there is no anchor. ``amount``
    turns measures (N,) into what a person would be told, in ``unit``; "" = nothing.
    """

    measure: Callable[[UprightBox, UprightBox], float]
    scale: float
    unit: str = ""
    amount: Callable[[Float64], Float64] = np.abs


def _log_volume(target: UprightBox, _: UprightBox) -> float:
    return sum(log(max(edge, SMALLEST_EDGE_M)) for edge in target.size)


def _height(target: UprightBox, _: UprightBox) -> float:
    return float(target.size[2])


def _length(target: UprightBox, _: UprightBox) -> float:
    return float(target.size[:2].max())


def _breadth(target: UprightBox, _: UprightBox) -> float:
    return float(target.size[:2].min())


def _level(target: UprightBox, _: UprightBox) -> float:
    return float(target.centre[2])


def _most(measure: Callable[[UprightBox, UprightBox], float]) -> Any:
    return lambda target, anchor: -measure(target, anchor)


SUPERLATIVES: dict[str, Superlative] = {
    "nearest": Superlative(distance, 0.05, "m away"),
    "farthest": Superlative(_most(distance), 0.05, "m away"),
    "largest": Superlative(_most(_log_volume), 0.1, "m3", lambda measure: np.exp(-measure)),
    "smallest": Superlative(_log_volume, 0.1, "m3", np.exp),
    "tallest": Superlative(_most(_height), 0.05, "m tall"),
    "shortest": Superlative(_height, 0.05, "m tall"),
    "longest": Superlative(_most(_length), 0.05, "m long"),
    "widest": Superlative(_most(_length), 0.05, "m wide"),
    "narrowest": Superlative(_breadth, 0.05, "m wide"),
    "highest": Superlative(_most(_level), 0.05),
    "lowest": Superlative(_level, 0.05),
}
"""Metres, and for sizes the logarithm of the volume: 0.1 is a tenth larger."""

COMPARED_TO_ANCHOR = ("nearest", "farthest")

SIDEWAYS = {"leftmost": 1.0, "rightmost": -1.0}
"""What is first by how far it is to the right of a standpoint: the least, or the most."""
SIDEWAYS_SCALE_M = 0.05


def probability_of_rank(weight: Float64, measure: Float64, scale: float, rank: int = 1) -> Float64:
    """Return for each target the probability that it is the ``rank``-th real one, (N,).

    ``weight`` (N,) in [0, 1] is the probability that a candidate is a real target at all. One is
    the third when it is real and two of the others are both real and before it, so a doubtful
    candidate that is a little nearer does not beat a certain one. Differences in ``measure`` (N,)
    below ``scale`` decide little: chairs of equal size are all a bit the largest.
    """
    ahead = (measure[:, None] - measure[None, :]) / scale
    before = 1.0 / (1.0 + np.exp(-np.clip(ahead, -50.0, 50.0)))
    np.fill_diagonal(before, 0.0)
    passed = np.zeros((len(weight), rank))  # probability that so many are before each
    passed[:, 0] = 1.0
    for is_before in (before * weight[None, :]).T[:, :, None]:
        one_more = np.pad(passed[:, :-1], ((0, 0), (1, 0)))
        passed = passed * (1.0 - is_before) + one_more * is_before
    ranked: Float64 = weight * passed[:, -1]
    return ranked
