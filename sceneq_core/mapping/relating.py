"""What carries an instance: the rules, from the surest evidence to the least."""

from collections.abc import Mapping
from dataclasses import dataclass

from sceneq_core.arrays import Bool
from sceneq_core.mapping.shape import Crowd, Shape
from sceneq_core.mapping.support import (
    SupportParams,
    WallShape,
    hangs_from,
    hangs_on,
    holds,
    mounted_on,
    next_below,
    standing_on,
)

_SURE = 0.9


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What is close to an instance, by id, and the floor: the id it goes by and its height.

    ``crowd`` are the ``objects`` as one table; ``carried`` bool (K,) marks those that stand on the
    instance itself.
    """

    objects: Mapping[int, Shape]
    crowd: Crowd
    carried: Bool
    walls: Mapping[int, WallShape]
    ceilings: Mapping[int, Shape]
    floor_id: int
    floor_m: float

    def raised_m(self, thing: Shape) -> float:
        """Return how far above the floor a thing begins; without a floor that is far."""
        return thing.bottom_m - self.floor_m


def carrier_of(thing: Shape, around: Surroundings, params: SupportParams) -> tuple[int, int]:
    """Return the ids of what carries a thing and of what it is inside of, 0 = not known."""
    carrier, fit = standing_on(thing, around.crowd, ~around.carried, params)
    if around.raised_m(thing) <= params.reach_m and fit < _SURE:
        # A door or a curtain reaches the floor, and yet hangs on its wall.
        return hangs_on(thing, around.walls, params) or around.floor_id, 0
    carrier = (
        carrier
        or hangs_on(thing, around.walls, params)
        or _holder(thing, around, params)
        or _below(thing, around, params)
        or mounted_on(thing, around.walls, params)
        or hangs_from(thing, around.ceilings, params)
    )
    holder = around.objects.get(carrier)
    return carrier, carrier if holder is not None and holds(holder, thing, params) else 0


def _holder(thing: Shape, around: Surroundings, params: SupportParams) -> int:
    """Return what holds a thing whose contact cannot be seen; 0 = nothing."""
    for (number, holder), carried in zip(around.objects.items(), around.carried, strict=True):
        if not carried and holder.bottom_m < thing.bottom_m and holds(holder, thing, params):
            return number
    return 0


def _below(thing: Shape, around: Surroundings, params: SupportParams) -> int:
    """Return what a thing stands on when its own foot, or what it stands on, is hidden."""
    raised_m = around.raised_m(thing)
    if raised_m > params.raised_m:
        number = next_below(thing, around.crowd, ~around.carried, params)
        if number:
            return number
    return around.floor_id if raised_m <= params.hidden_m else 0
