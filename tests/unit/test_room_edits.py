"""Things are moved, removed and added, and what they carry goes along."""

import numpy as np
import pytest

from sceneq_tools.room.layout.compose import compose
from sceneq_tools.room.layout.draft import carried_by
from sceneq_tools.room.layout.edits import added, moved, random_changes, removed
from sceneq_tools.room.models.shapes import ParametricLibrary
from sceneq_tools.room.room import FLOOR_ID, Room, Thing

LIBRARY = ParametricLibrary()


@pytest.fixture(scope="module")
def room() -> Room:
    return compose("kitchen", 1, LIBRARY)


def rng() -> np.random.Generator:
    return np.random.default_rng(5)


def first(room: Room, label: str) -> Thing:
    return next(thing for thing in room.things if thing.label == label)


def test_a_moved_thing_keeps_its_id_and_gets_a_new_support(room: Room) -> None:
    room = added(room, "stool", FLOOR_ID, LIBRARY, rng())
    stool = room.things[-1]
    room = added(room, "coffee mug", first(room, "dining table").id, LIBRARY, rng())
    mug = room.things[-1]
    after = moved(room, mug.id, stool.id, rng()).thing(mug.id)
    assert (after.support, after.relation) == (stool.id, "on")
    assert after.mesh is mug.mesh
    assert not np.allclose(after.T_world_thing, mug.T_world_thing)


def test_the_room_itself_is_not_changed(room: Room) -> None:
    before = [(t.id, t.T_world_thing.copy()) for t in room.things]
    random_changes(room, LIBRARY, rng(), 4)
    for thing, (thing_id, pose) in zip(room.things, before, strict=True):
        assert thing.id == thing_id
        assert np.array_equal(thing.T_world_thing, pose)


def test_what_a_thing_carries_goes_along(room: Room) -> None:
    room = added(room, "stool", FLOOR_ID, LIBRARY, rng())
    stool = room.things[-1]
    room = added(room, "coffee mug", stool.id, LIBRARY, rng(), tint="red")
    mug = room.things[-1]
    assert [t.id for t in carried_by(room.things, stool.id)] == [mug.id]
    after = moved(room, stool.id, FLOOR_ID, rng(), near_xy=(0.5, 0.5))
    relative = np.linalg.inv(stool.T_world_thing) @ mug.T_world_thing
    new = np.linalg.inv(after.thing(stool.id).T_world_thing) @ after.thing(mug.id).T_world_thing
    assert np.allclose(relative, new)
    assert not np.allclose(stool.T_world_thing, after.thing(stool.id).T_world_thing)


def test_removing_takes_away_what_it_carries(room: Room) -> None:
    table = first(room, "dining table")
    riders = {t.id for t in carried_by(room.things, table.id)}
    assert riders
    left = {t.id for t in removed(room, table.id).things}
    assert left == {t.id for t in room.things} - riders - {table.id}


def test_an_id_is_never_used_twice(room: Room) -> None:
    once = added(room, "coffee mug", FLOOR_ID, LIBRARY, rng())
    new = once.things[-1].id
    again = added(removed(once, new), "coffee mug", FLOOR_ID, LIBRARY, rng())
    assert again.things[-1].id == new + 1


def test_an_added_thing_has_the_asked_colour(room: Room) -> None:
    table = first(room, "dining table")
    mug = added(room, "coffee mug", table.id, LIBRARY, rng(), tint="blue").things[-1]
    assert (mug.label, mug.tint, mug.support) == ("coffee mug", "blue", table.id)


def test_near_xy_brings_it_close(room: Room) -> None:
    table = first(room, "dining table")
    corner = (table.T_world_thing @ np.array([0.3, 0.2, 0.0, 1.0]))[:2]
    mug = added(room, "coffee mug", FLOOR_ID, LIBRARY, rng(), near_xy=(1.0, 1.0)).things[-1]
    assert np.linalg.norm(mug.T_world_thing[:2, 3] - (1.0, 1.0)) < 1.0
    on_table = added(room, "coffee mug", table.id, LIBRARY, rng(), near_xy=tuple(corner))
    assert np.linalg.norm(on_table.things[-1].T_world_thing[:2, 3] - corner) < 0.6


def test_the_reason_is_said_when_it_does_not_fit(room: Room) -> None:
    mug = added(room, "coffee mug", FLOOR_ID, LIBRARY, rng()).things[-1]
    larger = added(room, "coffee mug", FLOOR_ID, LIBRARY, rng())
    with pytest.raises(
        ValueError, match=rf"nothing free on coffee mug \(id {mug.id}\) for wardrobe"
    ):
        added(larger, "wardrobe", mug.id, LIBRARY, rng())


@pytest.mark.parametrize("label", ["floor", "wall", "window", "door", "ceiling lamp"])
def test_the_house_stays_as_it_is(room: Room, label: str) -> None:
    with pytest.raises(ValueError, match="belongs to the house"):
        moved(room, first(room, label).id, FLOOR_ID, rng())


def test_mistakes_are_named(room: Room) -> None:
    table = first(room, "dining table")
    with pytest.raises(ValueError, match="nothing has id 60000"):
        removed(room, 60000)
    with pytest.raises(ValueError, match="no model of a 'unicorn'"):
        added(room, "unicorn", FLOOR_ID, LIBRARY, rng())
    with pytest.raises(ValueError, match="cannot be put on itself"):
        moved(room, table.id, table.id, rng())
    with pytest.raises(ValueError, match="cannot hang on a wall"):
        moved(room, table.id, first(room, "wall").id, rng())


def test_a_painting_can_hang_elsewhere(room: Room) -> None:
    painting = first(room, "painting")
    wall = next(t for t in room.things if t.label == "wall" and t.id != painting.support)
    after = moved(room, painting.id, wall.id, rng()).thing(painting.id)
    assert (after.support, after.relation) == (wall.id, "against")


def test_random_changes_are_told(room: Room) -> None:
    changed, told = random_changes(room, LIBRARY, rng(), 6)
    assert len(told) == 6
    assert all(sentence.split()[0] in ("moved", "removed", "added") for sentence in told)
    assert changed.next_id >= room.next_id
    again, told_again = random_changes(room, LIBRARY, rng(), 6)
    assert told_again == told
    assert len(again.things) == len(changed.things)


def test_only_what_is_seen_changes(room: Room) -> None:
    table = first(room, "dining table").id
    small = [t.id for t in room.things if t.support == table and t.category.role == "top"]
    changed, told = random_changes(room, LIBRARY, rng(), 3, {table, *small})
    left = {thing.id: thing for thing in changed.things}
    touched = {
        thing.id
        for thing in room.things
        if thing.id not in left
        or not np.array_equal(left[thing.id].T_world_thing, thing.T_world_thing)
    }
    newcomers = [thing for thing in changed.things if thing.id >= room.next_id]
    assert told
    assert touched <= set(small)
    assert all(thing.support == table for thing in newcomers)


def test_what_belongs_on_the_floor_stays_there(room: Room) -> None:
    room = added(room, "trash can", FLOOR_ID, LIBRARY, rng())
    bin_id = room.things[-1].id
    for seed in range(4):
        seen = {bin_id, FLOOR_ID, first(room, "dining table").id}
        after, _ = random_changes(room, LIBRARY, np.random.default_rng(seed), 1, seen)
        assert all(thing.support == FLOOR_ID for thing in after.things if thing.id == bin_id)
