"""Whatever the seed: things stand on what carries them, and nothing is inside anything else."""

from functools import cache
from itertools import combinations

import numpy as np
import pytest

from sceneq_tools.room.layout.compose import compose
from sceneq_tools.room.layout.draft import DOORWAY_M, is_rug
from sceneq_tools.room.layout.edits import random_changes
from sceneq_tools.room.layout.placement import collide, footprint, front_area, heights
from sceneq_tools.room.layout.probe import Probe
from sceneq_tools.room.models.shapes import ParametricLibrary
from sceneq_tools.room.room import FLOOR_ID, Room, Thing

LIBRARY = ParametricLibrary()
ROOMS = [("kitchen", 3), ("bedroom", 3), ("office", 71), ("living_room", 9203), ("mixed", 518)]
rooms = pytest.mark.parametrize(("kind", "seed"), ROOMS)
STANDS_M = 0.0021


@cache
def composed(kind: str, seed: int) -> Room:
    """Return a room, made once: that takes longer than to look it over."""
    return compose(kind, seed, LIBRARY)


def surface_below(thing: Thing, host: Thing) -> float:
    """Return the highest point of the host at or below the thing's base, under its middle."""
    base = heights(thing.mesh, thing.T_world_thing)[0]
    low, high = thing.mesh.vertices.min(0), thing.mesh.vertices.max(0)
    across = np.linspace(0.05, 0.95, 12)
    grid = np.stack(np.meshgrid(*(low[i] + across * (high[i] - low[i]) for i in (0, 1))), axis=-1)
    own = np.column_stack([grid.reshape(-1, 2), np.full(144, low[2] + 0.004), np.ones(144)])
    T_host_thing = np.linalg.inv(host.T_world_thing) @ thing.T_world_thing
    distance = Probe(host.mesh).first_hit((own @ T_host_thing.T)[:, :3], (0.0, 0.0, -1.0))
    return base + 0.004 - float(distance.min())


def free_things(room: Room) -> list[Thing]:
    return [t for t in room.things if not t.is_stuff and not is_rug(t)]


def assert_holds_together(room: Room) -> None:
    by_id = {thing.id: thing for thing in room.things}
    assert len(by_id) == len(room.things)
    assert by_id[FLOOR_ID].label == "floor"
    for thing in free_things(room):
        assert thing.support in by_id, thing.label
        host = by_id[thing.support]
        base = heights(thing.mesh, thing.T_world_thing)[0]
        if thing.relation in ("on", "in"):
            assert abs(surface_below(thing, host) - base) <= STANDS_M, (thing.label, host.label)
        elif thing.relation == "under":
            assert abs(base) <= STANDS_M
            assert (
                heights(thing.mesh, thing.T_world_thing)[1]
                < heights(host.mesh, host.T_world_thing)[1]
            )
        else:
            assert thing.relation == "against"
    for a, b in combinations(free_things(room), 2):
        if a.support != b.id and b.support != a.id:
            assert not collide(a.mesh, a.T_world_thing, b.mesh, b.T_world_thing), (a.label, b.label)


def assert_stays_inside(room: Room) -> None:
    width, depth, height = room.size_m
    for thing in free_things(room):
        if thing.label != "window":
            assert footprint(thing.mesh, thing.T_world_thing).within(width, depth), thing.label
            assert heights(thing.mesh, thing.T_world_thing)[1] <= height + 1e-6


@rooms
def test_nothing_floats_and_nothing_is_inside_anything(kind: str, seed: int) -> None:
    room = composed(kind, seed)
    assert_holds_together(room)
    assert_stays_inside(room)


@pytest.mark.parametrize(("kind", "seed"), ROOMS[:3])
def test_it_still_holds_after_random_changes(kind: str, seed: int) -> None:
    room = composed(kind, seed)
    changed, told = random_changes(room, LIBRARY, np.random.default_rng(seed), 5)
    assert len(told) == 5
    assert_holds_together(changed)
    assert_stays_inside(changed)


@rooms
def test_nothing_stands_before_the_door(kind: str, seed: int) -> None:
    room = composed(kind, seed)
    door = next(thing for thing in room.things if thing.label == "door")
    way = front_area(door.mesh, door.T_world_thing, DOORWAY_M - 0.05)
    for thing in free_things(room):
        if heights(thing.mesh, thing.T_world_thing)[0] < 1.9 and thing.id != door.id:
            assert not way.overlaps(footprint(thing.mesh, thing.T_world_thing)), thing.label


@pytest.mark.parametrize(("kind", "seed"), ROOMS[:2])
def test_the_same_seed_gives_the_same_room(kind: str, seed: int) -> None:
    first, second = composed(kind, seed), compose(kind, seed, ParametricLibrary())
    assert [(t.id, t.label, t.model_id, t.tint, t.support, t.relation) for t in first.things] == [
        (t.id, t.label, t.model_id, t.tint, t.support, t.relation) for t in second.things
    ]
    for a, b in zip(first.things, second.things, strict=True):
        assert np.array_equal(a.T_world_thing, b.T_world_thing)
        assert np.array_equal(a.mesh.vertices, b.mesh.vertices)
