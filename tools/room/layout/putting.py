"""Putting things on, in and under furniture."""

import math
from collections.abc import Sequence

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_tools.room.layout.laying import Preference, Spot, find_spot
from sceneq_tools.room.layout.probe import bounds
from sceneq_tools.room.layout.supports import Support, supports, underneath
from sceneq_tools.room.mesh import Mesh
from sceneq_tools.room.room import Thing

REACH_M = 1.75
"""Nobody puts things higher than this, and no camera would see them."""

KEEPERS = ("bookcase", "wardrobe", "kitchen_cabinet", "upper_cabinet", "nightstand", "tv_stand")
"""Roles of furniture with an inside: what stands on a covered level of them is *in* them."""

BASINS = ("kitchen_sink",)
"""Roles of furniture whose sunken level is an inside too."""

CARRIERS = ("on", "in")
"""Relations in which a thing moves along with its support."""


def levels_of(host: Thing, relation: str) -> tuple[Support, ...]:
    """Return the levels of a host that can be reached, the highest first."""
    if relation == "under":
        below = underneath(host.mesh)
        return () if below is None else (below,)
    base = float(host.T_world_thing[2, 3])
    return tuple(level for level in supports(host.mesh) if base + level.z < REACH_M)


def relation_to(host: Thing, level: Support, relation: str) -> str:
    """Return how something on a level is there: ``on``, ``in`` or ``under``."""
    if relation == "under":
        return relation
    kept = host.category.role in KEEPERS and level.covered
    sunk = host.category.role in BASINS and level.sunken
    return "in" if kept or sunk else "on"


def put(
    mesh: Mesh,
    host: Thing,
    things: Sequence[Thing],
    rng: np.random.Generator,
    where: str = "anywhere",
    relation: str = "on",
    straight: bool = False,
    near_xy: tuple[float, float] | None = None,
) -> tuple[Spot, str] | None:
    """Return a free spot for a mesh on, in or under a host and the relation; ``None`` if none.

    Args:
        mesh: what is to be placed.
        host: furniture or any other thing.
        things: everything in the room.
        rng: source of the choice among free spots.
        where: see ``Small.where``.
        relation: ``on`` (or in, where the level is inside) or ``under``.
        straight: parallel to the host.
        near_xy: world position that the spot should be close to.
    """
    preference = _near(host, near_xy) if near_xy else _preference(host.mesh, where, rng)
    for level in _shuffled(levels_of(host, relation), where, rng):
        for yaw in _turns(mesh, rng, straight):
            spot = find_spot(mesh, yaw, host, level, things, preference)
            if spot is not None:
                return spot, relation_to(host, level, relation)
    return None


def _shuffled(
    levels: tuple[Support, ...], where: str, rng: np.random.Generator
) -> tuple[Support, ...]:
    """Order the levels: large ones are likely first; only the highest when a place is named."""
    if where != "anywhere" or not levels:
        return levels[:1]
    weights = np.sqrt([level.area_m2 for level in levels])
    order = rng.choice(len(levels), len(levels), replace=False, p=weights / weights.sum())
    return tuple(levels[int(i)] for i in order)


def _turns(mesh: Mesh, rng: np.random.Generator, straight: bool) -> tuple[float, ...]:
    """Return the turns to try: as things are put down, then straight, then across."""
    low, high = bounds(mesh)
    is_large = float((high - low)[:2].max()) > 0.5
    casual = float(rng.normal(0, 0.05 if straight else 0.3))
    tried = (0.0,) if straight else (casual, 0.0)
    return (*tried, math.pi / 2) if not straight or is_large else tried


def _preference(mesh: Mesh, where: str, rng: np.random.Generator) -> Preference:
    low, high = bounds(mesh)
    middle = (low + high)[:2] / 2
    size = (high - low)[:2]

    def cost(centres: Float64) -> Float64:
        noise = rng.random(len(centres))
        if where == "centre":
            return np.asarray(np.linalg.norm(centres - middle, axis=1) + 0.03 * noise)
        if where == "back":
            sideways = np.abs(centres[:, 0] - middle[0])
            return np.asarray(-2 * centres[:, 1] + 0.5 * sideways + 0.03 * noise)
        if where == "seats":
            return np.asarray(-np.abs((centres - middle) / size).max(axis=1) + 0.15 * noise)
        return noise

    return cost


def _near(host: Thing, near_xy: tuple[float, float]) -> Preference:
    own = np.linalg.inv(host.T_world_thing) @ np.array([*near_xy, 0.0, 1.0])

    def cost(centres: Float64) -> Float64:
        return np.asarray(np.linalg.norm(centres - own[:2], axis=1))

    return cost
