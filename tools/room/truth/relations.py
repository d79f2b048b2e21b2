"""How the things of a room lie to each other, from its exact geometry."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from sceneq_core.checks import need_positive
from sceneq_tools.room.room import Room, Thing
from sceneq_tools.room.truth.boxes import Outline, covered_share, height_gap, level_gap, outline


@dataclass(frozen=True, slots=True)
class RelationParams:
    """What people mean, metres.

    Attributes:
        beside_m: neighbours are at most so far apart.
        level_m: neighbours may be so much higher or lower than each other.
        over_m: how far "above" reaches up.
        wall_m: what hangs on a wall is above furniture that stands so close to that wall.
        headroom_m: what is under a thing leaves so much of the thing's height above itself.
        covered: share of the outline that has to be under, or over, the other.
    """

    beside_m: float = 0.25
    level_m: float = 0.1
    over_m: float = 1.5
    wall_m: float = 0.45
    headroom_m: float = 0.05
    covered: float = 0.8

    def __post_init__(self) -> None:
        need_positive(self, *self.__dataclass_fields__)


@dataclass(frozen=True, slots=True)
class Relation:
    """``subject`` is ``kind`` the ``object``, both ids; ``gap_m`` between neighbours."""

    kind: str
    subject: int
    object: int
    gap_m: float | None = None


class Layout:
    """The outlines of a room's things, and who carries whom."""

    def __init__(self, room: Room) -> None:
        self.things = {thing.id: thing for thing in room.things}
        self.outlines = {thing.id: outline(thing) for thing in room.things}

    def carriers(self, thing_id: int) -> tuple[int, ...]:
        """Return what carries a thing, what carries that, and so on down."""
        chain: list[int] = []
        support = self.things[thing_id].support
        while support is not None and support in self.things and support not in chain:
            chain.append(support)
            support = self.things[support].support
        return tuple(chain)

    def carried(self, a: int, b: int) -> bool:
        """Tell whether one of the two carries the other."""
        return b in self.carriers(a) or a in self.carriers(b)


def relations(room: Room, params: RelationParams | None = None) -> tuple[Relation, ...]:
    """Return every relation, sorted: as placed (on, in, under, against), above, under, next_to.

    Floor, walls and ceiling carry things and are in no other relation. ``next_to`` is listed
    once for a pair, the lower id first.
    """
    params = params or RelationParams()
    layout = Layout(room)
    found = {*_placed(layout), *_vertical(layout, params), *_beside(layout, params)}
    return tuple(sorted(found, key=lambda r: (r.kind, r.subject, r.object)))


def is_above(layout: Layout, subject: int, anchor: int, params: RelationParams) -> bool:
    """Tell whether a thing is over another without resting on it."""
    upper, lower = layout.outlines[subject], layout.outlines[anchor]
    free = upper.low_m - lower.high_m
    if not 0 <= free <= params.over_m or layout.carried(subject, anchor):
        return False
    return covered_share(upper, lower) >= params.covered or _hangs_behind(
        layout.things[subject], upper, lower, params
    )


def is_under(layout: Layout, subject: int, anchor: int, params: RelationParams) -> bool:
    """Tell whether a thing is below a table or the like, within its outline."""
    lower, upper = layout.outlines[subject], layout.outlines[anchor]
    if lower.high_m > upper.high_m - params.headroom_m or layout.carried(subject, anchor):
        return False
    return covered_share(lower, upper) >= params.covered


def is_beside(layout: Layout, a: int, b: int, params: RelationParams) -> bool:
    """Tell whether two things are level neighbours."""
    mine, theirs = layout.outlines[a], layout.outlines[b]
    if height_gap(mine, theirs) > params.level_m or layout.carried(a, b):
        return False
    return 0 < level_gap(mine, theirs) <= params.beside_m


def _placed(layout: Layout) -> Iterator[Relation]:
    for thing in layout.things.values():
        if thing.support in layout.things and not thing.is_stuff:
            assert thing.support is not None
            yield Relation(thing.relation, thing.id, thing.support)


def _vertical(layout: Layout, params: RelationParams) -> Iterator[Relation]:
    for subject, anchor in _pairs(layout):
        if _far_apart(layout, subject, anchor, params.wall_m):
            continue
        if is_above(layout, subject, anchor, params):
            yield Relation("above", subject, anchor)
        elif is_under(layout, subject, anchor, params):
            yield Relation("under", subject, anchor)


def _beside(layout: Layout, params: RelationParams) -> Iterator[Relation]:
    for a, b in _pairs(layout):
        if a < b and not _far_apart(layout, a, b, params.beside_m):
            apart = level_gap(layout.outlines[a], layout.outlines[b])
            if is_beside(layout, a, b, params):
                yield Relation("next_to", a, b, round(apart, 3))


def _pairs(layout: Layout) -> Iterator[tuple[int, int]]:
    things = [thing.id for thing in layout.things.values() if not thing.is_stuff]
    return ((a, b) for a in things for b in things if a != b)


def _far_apart(layout: Layout, a: int, b: int, reach_m: float) -> bool:
    """Tell by bounding rectangles, quickly, that two things are out of each other's reach."""
    mine, theirs = layout.outlines[a].corners, layout.outlines[b].corners
    apart = np.maximum(mine.min(0) - theirs.max(0), theirs.min(0) - mine.max(0))
    return bool(apart.max() > reach_m)


def _hangs_behind(thing: Thing, upper: Outline, lower: Outline, params: RelationParams) -> bool:
    """Tell whether something on a wall has its middle over furniture that stands at that wall."""
    if thing.relation != "against" or level_gap(upper, lower) > params.wall_m:
        return False
    along_wall = thing.T_world_thing[:2, 0]
    reach = lower.corners @ along_wall
    return bool(reach.min() <= upper.centre @ along_wall <= reach.max())
