"""How alike two things have to be: the calibrated judgements that names are passed on by."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.teaching.logistic import Logistic

_THIN_M = 0.01

PLACE = Logistic((29.7,), -8.66)
"""Same place, same thing? Of the overlap of two boxes of one room that was mapped twice, from
frames of the one run that the other never saw; the rooms of docs/teaching.md."""


@dataclass(frozen=True, slots=True)
class Judgement:
    """What one encoder's image vectors are worth.

    ``alike``: of the cosine of two things, the probability that they are of one category; ``None``
    = never measured, then nothing is inherited. ``again``: of the overlap of their boxes in two
    maps of the room and the cosine, that they are the same thing; ``place``: of the overlap alone,
    for vectors that cannot be compared.
    """

    alike: Logistic | None = None
    again: Logistic | None = None
    place: Logistic = PLACE

    def __post_init__(self) -> None:
        for name, measures in (("alike", 1), ("again", 2), ("place", 1)):
            logistic = getattr(self, name)
            if logistic is not None and len(logistic.weights) != measures:
                raise ValueError(f"{name}: expected {measures} weights, got {logistic.weights}")
            if logistic is not None and min(logistic.weights) < 0:
                raise ValueError(f"{name}: a weight below 0 prefers what is less alike")

    def of_category(self, cosine: Float64) -> Float64:
        """Return p (N,) that things with ``cosine`` (N,) are of the category too; 0 unmeasured."""
        if self.alike is None:
            return np.zeros(len(cosine))
        return self.alike.p(np.asarray(cosine, np.float64)[:, None])

    def of_same(self, overlap: Float64, cosine: Float64 | None) -> Float64:
        """Return p (N,) that things with ``overlap`` (N,), and ``cosine`` (N,), are the same."""
        if cosine is None or self.again is None:
            return self.place.p(overlap[:, None])
        return self.again.p(np.column_stack([overlap, cosine]))


def box_overlap(aabb_world: Float64, others: Float64) -> Float64:
    """Return the intersection over union (N,) of a box (2, 3) with ``others`` (N, 2, 3), metres.

    An edge below a centimetre counts as one: a picture has no volume, but a place.
    """
    one, many = _thick(aabb_world[None]), _thick(others)
    shared = np.minimum(one[:, 1], many[:, 1]) - np.maximum(one[:, 0], many[:, 0])
    both = np.prod(np.maximum(shared, 0.0), axis=1)
    overlap: Float64 = both / (_volume(one) + _volume(many) - both)
    return overlap


def _thick(boxes: Float64) -> Float64:
    middle = boxes.mean(axis=1)
    half = np.maximum((boxes[:, 1] - boxes[:, 0]) / 2, _THIN_M / 2)
    return np.stack([middle - half, middle + half], axis=1)


def _volume(boxes: Float64) -> Float64:
    volume: Float64 = np.prod(boxes[:, 1] - boxes[:, 0], axis=1)
    return volume
