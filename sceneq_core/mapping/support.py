"""What carries a thing, what holds it and what is beside it: contact between patches."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int64
from sceneq_core.checks import need_positive, need_within
from sceneq_core.mapping.shape import LEVEL, UP, Crowd, Shape, gaps, within_reach


@dataclass(frozen=True, slots=True)
class SupportParams:
    """What counts as contact, metres.

    ``contact_m``: how far apart touching surfaces may seem, by noise and voxels; ``sideways_m``:
    how far beside a foot the surface it stands on may be seen, the rest is hidden under it.
    ``hidden_m``: how much of the foot of a thing on the floor may be hidden, ``raised_m`` of
    another. What is nowhere further than ``flat_m`` in front of a wall, or ``recess_m`` behind its
    surface, hangs on it; the visible part of a cupboard is up to ``deep_m`` in front of it.
    ``min_contact``: the share of the foot that has to stand on something; ``min_held``: the share
    of a thing's outline that is in the outline of what it is inside of. Neighbours are up to
    ``beside_m`` apart.
    """

    contact_m: float = 0.04
    sideways_m: float = 0.03
    hidden_m: float = 0.5
    raised_m: float = 0.15
    flat_m: float = 0.12
    recess_m: float = 0.3
    deep_m: float = 0.45
    min_contact: float = 0.2
    min_held: float = 0.75
    beside_m: float = 0.25

    def __post_init__(self) -> None:
        shares = ("min_contact", "min_held")
        need_positive(self, *(f for f in self.__dataclass_fields__ if f not in shares))
        need_within(self, 0, 1, *shares)

    @property
    def reach_m(self) -> float:
        """How far apart surfaces are that surely do not touch."""
        return 2.0 * self.contact_m


@dataclass(frozen=True, slots=True)
class WallShape:
    """A piece of wall: its patches, and in the level frame the normal of its plane and n @ p."""

    shape: Shape
    normal: Float64
    offset_m: float

    def range_m(self, thing: Shape) -> tuple[float, float]:
        """Return how far in front of the wall a thing begins and ends, but for a few voxels."""
        middle = (thing.low + thing.high) / 2.0 @ self.normal - self.offset_m
        half = (thing.high - thing.low) / 2.0 @ np.abs(self.normal)
        order = np.argsort(middle, kind="stable")
        reached = np.cumsum(thing.voxels[order]) / thing.voxels.sum()
        first, last = np.searchsorted(reached, (0.05, 0.95))
        return float((middle - half)[order][first]), float((middle + half)[order][last])


def standing_on(
    thing: Shape, crowd: Crowd, may_carry: Bool, params: SupportParams
) -> tuple[int, float]:
    """Return which of the crowd a thing stands on and how well, 0 to 1; id 0 = on none.

    How well is the share of its foot that has a top under it, counted by the gap between.
    ``may_carry`` bool (K,) says of whom in the crowd that may be.
    """
    away = np.abs(crowd.high[:, UP] - thing.bottom_m)
    carrying = _under(thing, crowd, may_carry, away < params.reach_m, params)
    if not len(carrying):
        return 0, 0.0
    foot = _foot(thing, params)
    touching = _sideways(thing, foot, crowd, carrying) < params.sideways_m
    fit = np.where(touching, np.exp(-((away[carrying] / params.contact_m) ** 2) / 2.0), 0.0)
    weight = thing.voxels[foot] / thing.voxels[foot].sum()
    owner = crowd.of[carrying]
    scores = {row: float(weight @ fit[:, owner == row].max(axis=1)) for row in np.unique(owner)}
    best = max(scores, key=lambda row: (scores[row], -row))
    if scores[best] < params.min_contact:
        return 0, 0.0
    return int(crowd.ids[best]), scores[best]


def next_below(thing: Shape, crowd: Crowd, may_carry: Bool, params: SupportParams) -> int:
    """Return whose top comes next below a thing, up to ``raised_m`` away; 0 = nobody's."""
    away = thing.bottom_m - crowd.high[:, UP]
    close = (away > -params.contact_m) & (away < params.raised_m)
    below = _under(thing, crowd, may_carry, close, params)
    if not len(below):
        return 0
    foot = _foot(thing, params)
    touching = _sideways(thing, foot, crowd, below) < params.sideways_m
    share = thing.voxels[foot] @ touching.any(axis=1) / thing.voxels[foot].sum()
    if share < params.min_contact:
        return 0
    away = np.where(touching.any(axis=0), away[below], np.inf)
    return int(crowd.ids[crowd.of[below][int(away.argmin())]])


def hangs_on(thing: Shape, walls: Mapping[int, WallShape], params: SupportParams) -> int:
    """Return the wall that all of a thing is flat on or recessed in; 0 = none.

    Of several pieces of wall it is the one closest to the middle of the thing.
    """
    flat = [
        number
        for number, wall in walls.items()
        if -params.recess_m <= wall.range_m(thing)[0] and wall.range_m(thing)[1] <= params.flat_m
    ]
    return _closest(thing, walls, flat)


def mounted_on(thing: Shape, walls: Mapping[int, WallShape], params: SupportParams) -> int:
    """Return the wall that a thing hangs on that is not flat, like a cupboard; 0 = none.

    Of its back and sides little is seen: it is closer to the wall than it is large.
    """
    size_m = float((thing.box[1] - thing.box[0]).max())
    reach_m = max(params.reach_m, min(size_m, params.deep_m))
    touching = [
        number
        for number, wall in walls.items()
        if -params.recess_m <= wall.range_m(thing)[0] <= reach_m
    ]
    return _closest(thing, walls, touching)


def hangs_from(thing: Shape, ceilings: Mapping[int, Shape], params: SupportParams) -> int:
    """Return the ceiling that the top of a thing touches; 0 = none."""
    touching = [n for n, s in ceilings.items() if abs(s.bottom_m - thing.top_m) <= params.reach_m]
    return min(touching, default=0)


def holds(holder: Shape, thing: Shape, params: SupportParams) -> bool:
    """Tell whether ``thing`` is in ``holder``: within its outline, roofed or walled in by it."""
    if _share_within(thing.box[:, LEVEL], holder.box[:, LEVEL]) < params.min_held:
        return False
    if holder.top_m < thing.middle[UP]:
        return False
    return _is_roofed(holder, thing, params) or _is_walled_in(holder, thing, params)


def beside(thing: Shape, crowd: Crowd, params: SupportParams) -> set[int]:
    """Return the ids of those in the crowd whose surface comes close to that of a thing."""
    close = within_reach(crowd.low, crowd.high, thing.box, params.beside_m)
    rows = np.unique(crowd.of[close])
    boxes = crowd.boxes[rows]
    near = gaps(thing.low, thing.high, boxes[:, 0], boxes[:, 1]).min(axis=0) <= params.beside_m
    return {int(number) for number in crowd.ids[rows[near]]}


def _foot(thing: Shape, params: SupportParams) -> Bool:
    """Tell which patches of a thing belong to its lower end."""
    return np.asarray(thing.low[:, UP] < thing.bottom_m + params.reach_m)


def _under(
    thing: Shape, crowd: Crowd, may_carry: Bool, close: Bool, params: SupportParams
) -> Int64:
    """Return which ``close`` tops of the crowd are in the outline of a thing, seen from above."""
    top = np.flatnonzero(close & crowd.is_top & may_carry[crowd.of])
    low, high = crowd.low[top][:, LEVEL], crowd.high[top][:, LEVEL]
    return top[within_reach(low, high, thing.box[:, LEVEL], params.sideways_m)]


def _sideways(thing: Shape, foot: Bool, crowd: Crowd, carrying: Int64) -> Float64:
    """Return how far the patches of a foot are beside those that may carry it, (N, M)."""
    return gaps(
        thing.low[foot][:, LEVEL],
        thing.high[foot][:, LEVEL],
        crowd.low[carrying][:, LEVEL],
        crowd.high[carrying][:, LEVEL],
    )


def _closest(thing: Shape, walls: Mapping[int, WallShape], numbers: list[int]) -> int:
    middle = thing.middle[None]
    away = {
        number: float(gaps(middle, middle, walls[number].shape.low, walls[number].shape.high).min())
        for number in numbers
    }
    return min(away, key=lambda number: (away[number], number), default=0)


def _share_within(inner: Float64, outer: Float64) -> float:
    """Return the share of a level rectangle (2, 2) that lies in another."""
    size = np.maximum(inner[1] - inner[0], 1e-6)
    common = np.minimum(inner[1], outer[1]) - np.maximum(inner[0], outer[0])
    return float((np.maximum(common, 0.0) / size).prod())


def _is_roofed(holder: Shape, thing: Shape, params: SupportParams) -> bool:
    """Tell whether the holder goes on above the middle of a thing: a shelf, a cupboard."""
    over = holder.low[:, UP] > thing.top_m - params.contact_m
    middle = thing.middle[None, LEVEL]
    away = gaps(middle, middle, holder.low[over][:, LEVEL], holder.high[over][:, LEVEL])
    return bool((away <= params.sideways_m).any())


def _is_walled_in(holder: Shape, thing: Shape, params: SupportParams) -> bool:
    """Tell whether the holder rises close around a thing on all sides: a bowl, a bin, a sink."""
    rising = holder.high[:, UP] > max(thing.middle[UP], thing.bottom_m + 1.5 * params.contact_m)
    rising &= holder.low[:, UP] > thing.bottom_m - params.contact_m
    away = (holder.low + holder.high)[rising][:, LEVEL] / 2.0 - thing.middle[LEVEL]
    reach_m = np.linalg.norm(thing.box[1, LEVEL] - thing.box[0, LEVEL]) / 2.0 + params.recess_m
    away = away[np.linalg.norm(away, axis=1) < reach_m]
    sector = np.floor(np.arctan2(away[:, 1], away[:, 0]) / (np.pi / 4.0)) % 8
    return len(np.unique(sector)) == 8
