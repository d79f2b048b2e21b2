"""Where a thing can go when a room is changed."""

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_tools.room.layout.draft import Draft, is_rug
from sceneq_tools.room.layout.hanging import hanging_place
from sceneq_tools.room.layout.placement import in_the_way, pose
from sceneq_tools.room.layout.probe import bounds
from sceneq_tools.room.layout.putting import put
from sceneq_tools.room.mesh import Mesh
from sceneq_tools.room.room import FLOOR_ID, Thing

PLACES_TRIED = 400
"""On the floor: enough to find a gap of half a metre in a large room."""

BUILT_IN = ("opening", "ceiling_lamp", "structure")
"""Roles of what belongs to the house."""

Place = tuple[Float64, int, str]
"""Pose in the world, id of the support, relation to it."""


def known(room_things: list[Thing] | tuple[Thing, ...], thing_id: int) -> Thing:
    """Return the thing with an id; raise ``ValueError`` when there is none."""
    for thing in room_things:
        if thing.id == thing_id:
            return thing
    raise ValueError(f"nothing has id {thing_id} in this room")


def name_of(thing: Thing) -> str:
    """Return label and id, as messages say it."""
    return f"{thing.label} (id {thing.id})"


def find_place(
    draft: Draft,
    thing: Thing,
    mesh: Mesh,
    onto: int,
    near_xy: tuple[float, float] | None,
    relation: str,
    riders: tuple[Thing, ...],
) -> Place:
    """Find a free place for a thing; raise ``ValueError`` that says why there is none."""
    host = known(draft.things, onto)
    if onto == FLOOR_ID or is_rug(host):
        place = _floor_place(draft, mesh, near_xy, riders, thing)
    elif host.label == "wall":
        place = _wall_place(draft, thing, host, near_xy)
    elif host.is_stuff or host.category.role in BUILT_IN:
        raise ValueError(f"nothing can be put on {name_of(host)}")
    else:
        place = _host_place(draft, thing, mesh, host, near_xy, relation, riders)
    if place is None:
        low, high = bounds(mesh)
        size = " x ".join(f"{side:.2f}" for side in high - low)
        raise ValueError(f"nothing free {relation} {name_of(host)} for {name_of(thing)}, {size} m")
    return place


def _floor_place(
    draft: Draft,
    mesh: Mesh,
    near_xy: tuple[float, float] | None,
    riders: tuple[Thing, ...],
    thing: Thing,
) -> Place | None:
    places = draft.rng.uniform((0.1, 0.1), np.array(draft.size_m[:2]) - 0.1, (PLACES_TRIED, 2))
    if near_xy is not None:
        places = places[np.argsort(np.linalg.norm(places - near_xy, axis=1))]
    for x, y in places:
        T_world = pose(x, y, 0.0, float(draft.rng.uniform(-np.pi, np.pi)))
        if draft.fits(mesh, T_world, 0.03):
            T_world[2, 3], support = draft.resting_height(mesh, T_world)
            if _riders_fit(draft, thing, T_world, riders):
                return T_world, support, "on"
    return None


def _host_place(
    draft: Draft,
    thing: Thing,
    mesh: Mesh,
    host: Thing,
    near_xy: tuple[float, float] | None,
    relation: str,
    riders: tuple[Thing, ...],
) -> Place | None:
    for _ in range(10 if riders else 1):
        found = put(
            mesh, host, draft.furniture(), draft.rng, relation=relation, near_xy=near_xy
        )  # fmt: skip
        if found is None:
            return None
        spot, related = found
        if _riders_fit(draft, thing, spot.T_world_thing, riders):
            return spot.T_world_thing, host.id, related
    return None


def _wall_place(
    draft: Draft, thing: Thing, host: Thing, near_xy: tuple[float, float] | None
) -> Place | None:
    if thing.category.role != "wall":
        raise ValueError(f"{name_of(thing)} cannot hang on a wall")
    wall = next((wall for wall in draft.walls if wall.id == host.id), None)
    if wall is None:
        return None
    alongs = draft.rng.uniform(0.0, wall.length_m, 100)
    if near_xy is not None:
        alongs = alongs[np.argsort(np.abs(alongs - wall.along(*near_xy)))]
    for along in alongs:
        T_world = hanging_place(draft, thing.mesh, wall, float(along))
        if T_world is not None:
            return T_world, wall.id, "against"
    return None


def _riders_fit(draft: Draft, thing: Thing, T_world: Float64, riders: tuple[Thing, ...]) -> bool:
    """Tell whether what a thing carries is in nobody's way after the move."""
    T_change = T_world @ np.linalg.inv(thing.T_world_thing)
    return not any(
        in_the_way(rider.mesh, T_change @ rider.T_world_thing, draft.furniture())
        for rider in riders
    )
