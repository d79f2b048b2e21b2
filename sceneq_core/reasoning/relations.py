"""How well a spatial relation holds between two boxes, from 0 (not at all) to 1.

The functions fall off gently: boxes of half-seen things are some centimetres wrong.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import exp

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.checks import need_positive
from sceneq_core.reasoning.upright import UprightBox, distance, overlap, separation

LEVEL = slice(0, 2)
UP = 2


@dataclass(frozen=True, slots=True)
class RelationParams:
    """Metric scales of the relations, metres.

    ``contact_m``: how far apart touching things may seem; sensor noise and voxels make this some
    centimetres. ``reach_m``: an arm's length, the scale of "next to". ``near_m``: a few steps.
    ``height_m``: how far "above" and "under" reach within a room. ``thinnest_m``: thickness below
    which a box edge is noise. ``flat_m``: thickness up to which a standing thing is a surface that
    other things hang on.
    """

    contact_m: float = 0.08
    reach_m: float = 0.5
    near_m: float = 1.5
    height_m: float = 1.5
    thinnest_m: float = 0.05
    flat_m: float = 0.3

    def __post_init__(self) -> None:
        need_positive(self, *self.__dataclass_fields__)


@dataclass(frozen=True, slots=True)
class Pair:
    """Target and anchor in the anchor's upright frame.

    ``offset_viewer`` (3,) is the target's centre seen from the anchor's: metres to the viewer's
    right, away from the viewer, and up.
    """

    target: UprightBox
    anchor: UprightBox
    offset_viewer: Float64


Score = Callable[[Pair, RelationParams], float]


def next_to(pair: Pair, params: RelationParams) -> float:
    """Level neighbours within reach; what lies on or under the anchor is rather not beside it."""
    beside = 1.0 - 0.5 * overlap(pair.target, pair.anchor, LEVEL, params.thinnest_m)
    return beside * exp(-distance(pair.target, pair.anchor) / params.reach_m)


def near(pair: Pair, params: RelationParams) -> float:
    """Close in any direction."""
    return exp(-distance(pair.target, pair.anchor) / params.near_m)


def on(pair: Pair, params: RelationParams) -> float:
    """Resting on top; else held within (a seat, a shelf); else hanging on an upright surface."""
    return max(_rests(pair, params), 0.7 * _held(pair, params), _hangs(pair, params))


def under(pair: Pair, params: RelationParams) -> float:
    """Below the anchor's top and mostly within its outline."""
    covered = overlap(pair.target, pair.anchor, LEVEL, params.thinnest_m)
    clearance = float(pair.anchor.low[UP] - pair.target.high[UP])
    lower = _at_least(float(pair.anchor.centre[UP] - pair.target.centre[UP]), params.contact_m)
    return covered * lower * exp(-max(0.0, clearance) / params.height_m)


def above(pair: Pair, params: RelationParams) -> float:
    """Higher than the anchor's top; over it, or at the wall behind it."""
    clearance = float(pair.target.low[UP] - pair.anchor.high[UP])
    aside = float(np.linalg.norm(separation(pair.target, pair.anchor)[LEVEL]))
    reach = exp(-max(0.0, clearance) / params.height_m) * exp(-aside / params.reach_m)
    return _at_least(clearance, params.contact_m) * reach


def inside(pair: Pair, params: RelationParams) -> float:
    """The share of the target in the anchor's box."""
    return overlap(pair.target, pair.anchor, slice(0, 3), params.thinnest_m)


def supports(pair: Pair, params: RelationParams) -> float:
    """The anchor is on the target."""
    return on(_turned(pair), params)


def contains(pair: Pair, params: RelationParams) -> float:
    """The anchor is in the target."""
    return inside(_turned(pair), params)


def far_from(pair: Pair, params: RelationParams) -> float:
    """Not near."""
    return 1.0 - near(pair, params)


def left_of(pair: Pair, params: RelationParams) -> float:
    """To the left, seen from the viewer."""
    return _towards(pair, np.array([-1.0, 0.0]), params)


def right_of(pair: Pair, params: RelationParams) -> float:
    """To the right, seen from the viewer."""
    return _towards(pair, np.array([1.0, 0.0]), params)


def in_front_of(pair: Pair, params: RelationParams) -> float:
    """Between the viewer and the anchor."""
    return _towards(pair, np.array([0.0, -1.0]), params)


def behind(pair: Pair, params: RelationParams) -> float:
    """Beyond the anchor, seen from the viewer."""
    return _towards(pair, np.array([0.0, 1.0]), params)


def between(target: UprightBox, one: UprightBox, other: UprightBox, reach_m: float) -> float:
    """In the gap between two things, level: past the one, before the other, not far aside.

    All three in one upright frame. How far is aside grows with how far the two are apart.
    """
    start, end, point = (box.centre[LEVEL] for box in (one, other, target))
    way = end - start
    length = float(np.linalg.norm(way))
    if length == 0.0:
        return 0.0
    along = float((point - start) @ way) / length**2
    aside = abs(float(way[0] * (point - start)[1] - way[1] * (point - start)[0])) / length
    within = _at_least(min(along, 1.0 - along), 0.1)
    return within * exp(-aside / (0.5 * reach_m + 0.25 * length))


RELATIONS: dict[str, Score] = {
    "next_to": next_to,
    "near": near,
    "on": on,
    "under": under,
    "above": above,
    "in": inside,
    "supports": supports,
    "contains": contains,
    "far_from": far_from,
    "left_of": left_of,
    "right_of": right_of,
    "in_front_of": in_front_of,
    "behind": behind,
}

BY_DISTANCE = ("next_to", "near", "far_from")

VIEWER_RELATIVE = ("left_of", "right_of", "in_front_of", "behind")


def _turned(pair: Pair) -> Pair:
    return Pair(target=pair.anchor, anchor=pair.target, offset_viewer=-pair.offset_viewer)


def _rests(pair: Pair, params: RelationParams) -> float:
    gap = float(pair.target.low[UP] - pair.anchor.high[UP])
    supported = overlap(pair.target, pair.anchor, LEVEL, params.thinnest_m)
    return supported * exp(-((gap / params.contact_m) ** 2) / 2)


def _held(pair: Pair, params: RelationParams) -> float:
    """Above the anchor's foot, below its top: a cushion on a sofa, a book on a shelf."""
    raised = _at_least(float(pair.target.low[UP] - pair.anchor.low[UP]), params.contact_m)
    peak = _at_least(float(pair.anchor.high[UP] - pair.target.low[UP]), params.contact_m)
    return raised * peak * overlap(pair.target, pair.anchor, LEVEL, params.thinnest_m)


def _hangs(pair: Pair, params: RelationParams) -> float:
    thickness = float(pair.anchor.size[LEVEL].min())
    flat = exp(-max(0.0, thickness - params.flat_m) / params.flat_m)
    contact = exp(-distance(pair.target, pair.anchor) / params.contact_m)
    within = overlap(pair.target, pair.anchor, slice(UP, UP + 1), params.thinnest_m)
    standing = pair.anchor.size[UP] > pair.anchor.size[LEVEL].min()
    return flat * contact * within if standing else 0.0


def _towards(pair: Pair, direction: Float64, params: RelationParams) -> float:
    """The cosine between the level offset and a direction, fading with distance."""
    offset = pair.offset_viewer[LEVEL]
    length = float(np.linalg.norm(offset))
    if length == 0.0:
        return 0.0
    cosine = float(offset @ direction) / length
    return max(0.0, cosine) * exp(-distance(pair.target, pair.anchor) / params.near_m)


def _at_least(value_m: float, softness_m: float) -> float:
    """A soft step: 0.5 at zero, 0.98 at two softnesses."""
    return 1.0 / (1.0 + exp(-float(np.clip(2 * value_m / softness_m, -50, 50))))
