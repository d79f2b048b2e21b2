"""Words that compare the targets with each other: nearest, largest, highest."""

from collections.abc import Callable

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.reasoning.upright import UprightBox, distance

Measure = Callable[[UprightBox, UprightBox | None], float]


def _distance(target: UprightBox, anchor: UprightBox | None) -> float:
    return 0.0 if anchor is None else distance(target, anchor)


def _volume(target: UprightBox, _: UprightBox | None) -> float:
    return float(np.prod(target.size))


SUPERLATIVES: dict[str, Measure] = {
    "nearest": _distance,
    "farthest": lambda target, anchor: -_distance(target, anchor),
    "largest": lambda target, anchor: -_volume(target, anchor),
    "smallest": _volume,
    "tallest": lambda target, _: -float(target.size[2]),
    "highest": lambda target, _: -float(target.centre[2]),
    "lowest": lambda target, _: float(target.centre[2]),
}
"""Superlative -> what it makes small."""

COMPARED_TO_ANCHOR = ("nearest", "farthest")


def probability_of_first(weight: Float64, measure: Float64) -> Float64:
    """Return for each target the probability that it is the first real one, (N,).

    ``weight`` (N,) in [0, 1] is the probability that a candidate is a real target at all; sorted
    by ``measure``, it is the first when it is real and all before it are not. So a doubtful
    candidate that is a little nearer does not beat a certain one.
    """
    order = np.lexsort((-weight, measure))
    real = weight[order]
    none_before = np.concatenate(([1.0], np.cumprod(1.0 - real)[:-1]))
    first = np.empty_like(real)
    first[order] = real * none_before
    return first
