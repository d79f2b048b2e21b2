"""Structure, support, containment and closeness in rooms of sheets."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.mapping.delta import REMOVED
from sceneq_core.mapping.scene_graph import SceneGraphParams
from sceneq_core.mapping.structure import StructureParams
from sceneq_core.mapping.support import SupportParams
from sceneq_core.mapping.walls import WallParams

from support.sheets import BROWN, GREY, RED, WHITE, GraphedRoom, empty_room, furnished_room

ROOM = GraphedRoom(furnished_room())


@pytest.mark.parametrize(
    ("name", "role"),
    [
        ("floor", "floor"),
        ("ceiling", "ceiling"),
        ("wall_x", "wall"),
        ("wall_y", "wall"),
        ("table", "object"),
        ("picture", "object"),
        ("rug", "object"),
        ("shelf", "object"),
    ],
)
def test_the_building_is_told_from_what_is_in_it(name, role):
    assert ROOM.of(name).role == role


@pytest.mark.parametrize(
    ("name", "carrier"),
    [
        ("table", "floor"),
        ("stool", "floor"),
        ("rug", "floor"),
        ("shelf", "floor"),
        ("cup", "table"),
        ("book", "shelf"),
        ("picture", "wall_x"),
        ("lamp", "ceiling"),
        ("floor", ""),
        ("wall_x", ""),
    ],
)
def test_everything_is_carried_by_what_it_touches(name, carrier):
    assert ROOM.name(ROOM.of(name).supported_by) == carrier


def test_only_what_is_enclosed_is_inside():
    held = {name: ROOM.name(ROOM.of(name).inside) for name in ROOM.by_name}
    assert {name: holder for name, holder in held.items() if holder} == {"book": "shelf"}


def test_neighbours_are_close_objects_and_know_each_other():
    beside = {name: related[3] for name, related in ROOM.relations().items()}
    assert beside["stool"] == ["table"]
    assert beside["cup"] == ["table"]
    assert {"cup", "stool"} <= set(beside["table"])
    assert beside["picture"] == []
    assert beside["floor"] == []


def test_the_floor_tells_up_better_than_the_estimate():
    estimate = np.array([0.03, 0.02, 1.0])
    up_world = ROOM.graph.up_world(estimate / np.linalg.norm(estimate))
    assert up_world == pytest.approx([0.0, 0.0, 1.0], abs=1e-3)


def test_what_was_told_adds_up_to_the_whole():
    told = {one.instance_id: one for one in ROOM.told}
    assert related(told) == related(ROOM.graph.instances)


def test_nothing_is_told_twice():
    assert ROOM.update(()) == []


def test_what_stood_on_a_removed_thing_is_related_anew():
    room = GraphedRoom(furnished_room())
    gone = replace(room.of("table"), state=REMOVED)
    told = {one.instance_id: one for one in room.update((gone,))}
    assert told[gone.instance_id].state == REMOVED
    assert gone.instance_id not in room.graph.instances
    assert room.of("cup").supported_by != gone.instance_id
    assert gone.instance_id not in room.of("stool").neighbour_id


def test_a_counter_is_no_wall_and_no_floor():
    room = empty_room()
    room.sheet("counter", BROWN, (0.5, 0.6, 0), (3, 0, 0), (0, 0, 0.9), (0, 1, 0))
    room.sheet("counter", BROWN, (0.5, 0.0, 0.9), (3, 0, 0), (0, 0.6, 0), (0, 0, 1))
    assert GraphedRoom(room).of("counter").role == "object"


def test_a_wardrobe_in_front_of_a_wall_is_no_wall():
    room = empty_room()
    room.sheet("wardrobe", WHITE, (1.0, 0.6, 0), (1.6, 0, 0), (0, 0, 2.0), (0, 1, 0))
    graphed = GraphedRoom(room)
    assert graphed.of("wardrobe").role == "object"
    assert graphed.of("wall_y").role == "wall"


def test_pieces_of_a_wall_are_walls_and_a_door_in_it_is_not():
    room = empty_room()
    room.sheet("piece", WHITE, (4.1, 0, 0), (0.5, 0, 0), (0, 0, 2.0), (0, 1, 0))
    room.sheet("door", BROWN, (4.6, 0, 0), (0.9, 0, 0), (0, 0, 2.0), (0, 1, 0))
    graphed = GraphedRoom(room)
    assert graphed.of("piece").role == "wall"
    assert graphed.of("door").role == "object"
    assert graphed.name(graphed.of("door").supported_by) in ("wall_y", "piece")


def test_without_structure_nothing_stands_on_anything():
    room = empty_room()
    room.names, room.points, room.normals, room.rgb = [], [], [], []
    room.box("crate", RED, (0, 0, 0), (0.3, 0.3, 0.3))
    graphed = GraphedRoom(room)
    assert graphed.relations() == {"crate": ("object", "", "", [])}
    assert graphed.graph.up_world(np.array([0.0, 0.0, 1.0])).tolist() == [0.0, 0.0, 1.0]


def test_the_lowest_large_level_surface_is_the_floor():
    room = empty_room()
    room.sheet("platform", GREY, (0.5, 0.5, 0.3), (2, 0, 0), (0, 2, 0), (0, 0, 1))
    graphed = GraphedRoom(room)
    assert graphed.of("platform").role == "object"
    assert graphed.of("floor").role == "floor"


@pytest.mark.parametrize(
    ("params", "values", "field"),
    [
        (SceneGraphParams, {"per_keyframe": 0}, "per_keyframe"),
        (SceneGraphParams, {"moved_m": 0.0}, "moved_m"),
        (StructureParams, {"min_share": 1.5}, "min_share"),
        (StructureParams, {"reach_m": 0.0}, "reach_m"),
        (SupportParams, {"contact_m": -1.0}, "contact_m"),
        (SupportParams, {"min_held": 2.0}, "min_held"),
        (WallParams, {"lean_deg": 60.0}, "lean_deg"),
        (WallParams, {"min_area_m2": 0.0}, "min_area_m2"),
    ],
)
def test_a_bad_parameter_is_named(params, values, field):
    with pytest.raises(ValueError, match=f"^{field}: "):
        params(**values)


def related(instances):
    return {
        number: (one.role, one.supported_by, one.inside, one.neighbour_id.tolist())
        for number, one in instances.items()
    }
