"""What people say to a simulation, and what becomes of the room."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.ingest.source import RefusedError
from sceneq_tools.room.models.shapes import ParametricLibrary
from sceneq_tools.room.room import FLOOR_ID, Room
from sceneq_tools.sim.names import find, movable, phrase
from sceneq_tools.sim.world import World

from support.boxed_room import BLUE, boxed_room, placed, thing


def room_with_two_mugs() -> Room:
    room = boxed_room()
    blue = replace(
        thing(14, "mug", "top", (0.09, 0.09, 0.1), placed(2.4, 2.0, 0.42), 10, BLUE), tint="blue"
    )
    things = tuple(replace(t, tint="red") if t.id == 8 else t for t in room.things)
    return replace(room, things=(*things, blue))


@pytest.fixture
def shown() -> list[Room]:
    return []


@pytest.fixture
def world(shown: list[Room]) -> World:
    return World(room_with_two_mugs(), ParametricLibrary(), shown.append)


@pytest.mark.parametrize(
    ("said", "thing_id"),
    [("red mug", 8), ("Red Mug", 8), ("blue mug", 14), ("9", 9), ("the table", 10), ("Sofa", 6)],
)
def test_a_thing_is_meant_by_its_words_or_its_number(said: str, thing_id: int) -> None:
    room = room_with_two_mugs()
    assert find(room, said, movable(room)).id == thing_id


def test_several_are_listed_with_their_numbers() -> None:
    room = room_with_two_mugs()
    with pytest.raises(RefusedError) as caught:
        find(room, "mug", movable(room))
    said = "'mug' fits 2 things: 8 red mug on the desk; 14 blue mug on the coffee table"
    assert str(caught.value) == said
    assert caught.value.hint == "say its number"


@pytest.mark.parametrize(
    ("said", "hint"),
    [
        ("mugg", "did you mean 'mug'?"),
        ("zeppelin", "see: sceneq sim list"),
        ("", "see: sceneq sim list"),
        ("999", "see: sceneq sim list"),
    ],
)
def test_what_is_not_there_is_refused_with_a_hint(said: str, hint: str) -> None:
    room = boxed_room()
    with pytest.raises(RefusedError) as caught:
        find(room, said, movable(room))
    assert caught.value.hint == hint


def test_the_building_is_not_movable() -> None:
    room = boxed_room()
    assert "floor" not in {t.label for t in movable(room)}
    assert phrase(room, room.thing(8)) == "mug on the desk"
    assert phrase(room, room.thing(FLOOR_ID)) == "floor"


def test_a_moved_thing_stands_where_it_is_said_to(world: World, shown: list[Room]) -> None:
    told = world.move({"thing": "red mug", "onto": "coffee table"})
    mug = world.room.thing(8)
    assert (told["verb"], told["was"], told["id"]) == ("moved", "red mug on the desk", 8)
    assert (told["relation"], told["on"], told["on_id"]) == ("on", "coffee table", 10)
    assert mug.support == 10
    assert told["centre_m"] == pytest.approx([*mug.T_world_thing[:2, 3], 0.42 + 0.05], abs=0.011)
    assert np.abs(mug.T_world_thing[:2, 3] - (2.5, 2.0)).max() < 0.45
    assert shown == [world.room]
    assert world.listed()["edits"] == 1


def test_what_stands_on_a_thing_goes_with_it(world: World) -> None:
    told = world.remove({"thing": "desk"})
    assert told["was"] == "desk on the floor"
    assert sorted(told["gone"]) == [7, 8, 9]
    assert {t.id for t in world.room.things} & {7, 8, 9} == set()


def test_a_new_thing_comes_from_the_library(world: World) -> None:
    told = world.add({"thing": "mug", "onto": "coffee table", "colour": "green"})
    new = world.room.thing(told["id"])
    assert told["id"] == 15
    assert (new.tint, new.support, "mug" in new.label) == ("green", 10, True)
    assert told["on"] == "coffee table"


@pytest.mark.parametrize(
    ("verb", "arguments", "message", "hint"),
    [
        ("move", {"thing": "book"}, "'onto' is missing", "onto=NAME or onto=NUMBER"),
        ("move", {"onto": "desk"}, "'thing' is missing", "thing=NAME or thing=NUMBER"),
        ("move", {"thing": "book", "onto": "9"}, "the book cannot stand on itself", ""),
        ("remove", {"thing": "floor"}, "there is no 'floor' that could be meant", "sim list"),
        ("add", {"thing": "zeppelin", "onto": "desk"}, "there is no model of a 'zeppelin'", ""),
        ("add", {"thing": "mug", "onto": "desk", "colour": "grue"}, "no paint 'grue'", "known: "),
        ("move", {"thing": "sofa", "onto": "red mug"}, "", ""),
    ],
)
def test_a_refused_change_leaves_the_room_as_it_was(
    world: World, shown: list[Room], verb: str, arguments: dict[str, str], message: str, hint: str
) -> None:
    before = world.room
    with pytest.raises(RefusedError) as caught:
        getattr(world, verb)(arguments)
    assert message in str(caught.value)
    assert hint in caught.value.hint
    assert world.room is before
    assert not shown


def test_every_thing_is_listed_with_its_place(world: World) -> None:
    listed = world.listed()
    assert (listed["room"], listed["seed"], len(listed["things"])) == ("office", 0, 9)
    book = next(t for t in listed["things"] if t["id"] == 9)
    assert book == {
        "id": 9,
        "label": "book",
        "colour": None,
        "relation": "on",
        "on": "desk",
        "on_id": 7,
        "centre_m": [4.6, 1.5, 0.765],
        "size_m": [0.2, 0.14, 0.05],
    }
