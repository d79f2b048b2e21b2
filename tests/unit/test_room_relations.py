from dataclasses import replace

import numpy as np

from sceneq_tools.room.room import FLOOR_ID, Room
from sceneq_tools.room.truth.relations import Layout, Relation, relations

from support.boxed_room import boxed_room, placed, thing


def found(room: Room, kind: str) -> set[tuple[int, int]]:
    return {(r.subject, r.object) for r in relations(room) if r.kind == kind}


def with_things(*things) -> Room:
    room = boxed_room()
    return replace(room, things=room.things + things)


def test_what_stands_on_a_desk_is_on_it_and_the_floor_is_on_nothing() -> None:
    on = found(boxed_room(), "on")
    assert {(8, 7), (9, 7), (7, FLOOR_ID)} <= on
    assert not any(subject == FLOOR_ID for subject, _ in on)


def test_carriers_go_down_to_the_floor() -> None:
    assert Layout(boxed_room()).carriers(8) == (7, FLOOR_ID)


def test_a_box_below_a_table_is_under_it() -> None:
    shelf = thing(20, "shelf", "floor", (1.2, 0.6, 0.1), placed(2.0, 1.0, 0.6))
    box = thing(21, "box", "floor", (0.3, 0.3, 0.3), placed(2.0, 1.0))
    beside = thing(22, "box", "floor", (0.3, 0.3, 0.3), placed(2.0, 2.2))
    room = with_things(shelf, box, beside)
    assert (21, 20) in found(room, "under")
    assert not {22, 8} & {subject for subject, _ in found(room, "under")}


def test_a_picture_is_above_the_furniture_below_it_only() -> None:
    room = boxed_room()
    picture = replace(room.thing(13), relation="against")
    sideboard = thing(20, "sideboard", "dresser", (1.0, 0.4, 0.8), placed(3.2, 3.7))
    stool = thing(21, "stool", "stool", (0.4, 0.4, 0.5), placed(4.4, 3.7))
    others = tuple(t for t in room.things if t.id != 13)
    room = replace(room, things=(*others, picture, sideboard, stool))
    assert (13, 20) in found(room, "above")
    assert (13, 21) not in found(room, "above")


def test_neighbours_are_listed_once_with_their_gap() -> None:
    a = thing(20, "cup", "top", (0.1, 0.1, 0.1), placed(2.0, 1.0))
    b = thing(21, "cup", "top", (0.1, 0.1, 0.1), placed(2.0, 1.25, yaw=np.pi / 2))
    far = thing(22, "cup", "top", (0.1, 0.1, 0.1), placed(2.0, 1.9))
    rows = [r for r in relations(with_things(a, b, far)) if r.kind == "next_to"]
    assert Relation("next_to", 20, 21, 0.15) in rows
    assert not any({20, 22} == {r.subject, r.object} for r in rows)


def test_what_carries_a_thing_is_not_next_to_it() -> None:
    assert (7, 8) not in found(boxed_room(), "next_to")
