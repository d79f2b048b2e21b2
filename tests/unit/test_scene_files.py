"""What `sceneq map` leaves on disk can be read and drawn again."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from sceneq_tools.errors import UserError
from sceneq_tools.scene_files import read_scene, scene_graph
from sceneq_tools.scene_picture import box_corners, scene_picture, write_png
from sceneq_tools.view_command import asked, marks_of_answer, marks_of_ids, parsed_size, run

from support.furnished_cloud import BOX_M, BOXES, VOXEL_M, open_room


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    scene = open_room()
    np.savez_compressed(
        tmp_path / "instances.npz",
        points=scene.points_world,
        instance_id=scene.instance_id,
        rgb=scene.rgb,
    )
    records = [record(number, *place) for number, place in BOXES.items()]
    document = {
        "scene": "room", "frame_seq": 9, "voxel_size_m": VOXEL_M, "up_world": [0.0, 0.0, 1.0],
        "points": len(scene.points_world), "instance_count": 3, "digest": "0123456789abcdef",
        "instances": records,
    }  # fmt: skip
    (tmp_path / "instances.json").write_text(json.dumps(document))
    return tmp_path


def record(number: int, x: float, y: float) -> dict[str, object]:
    half = BOX_M / 2
    box = {
        "centre": [x + half, y + half, half],
        "size": [BOX_M] * 3,
        "rotation": np.eye(3).tolist(),
    }
    return {"id": number, "label": "box", "p": 0.4, "box_oriented": box}


def test_a_folder_is_read_back(folder: Path) -> None:
    cloud, document = read_scene(folder)
    assert (cloud.points_world == open_room().points_world).all()
    assert cloud.voxel_size_m == VOXEL_M
    assert [record["id"] for record in document["instances"]] == list(BOXES)


def test_maps_without_colours_are_read_as_well(folder: Path) -> None:
    scene = open_room()
    np.savez(folder / "instances.npz", points=scene.points_world, instance_id=scene.instance_id)
    cloud, _ = read_scene(folder)
    assert cloud.rgb.shape == cloud.points_world.shape


@pytest.mark.parametrize("name", ["instances.npz", "instances.json"])
def test_what_is_missing_or_broken_is_told_by_name(folder: Path, name: str) -> None:
    (folder / name).write_text("{}")
    with pytest.raises(UserError, match="cannot be read"):
        read_scene(folder)
    (folder / name).unlink()
    with pytest.raises(UserError, match=f"no {name} in it"):
        read_scene(folder)


def test_view_writes_a_picture_of_the_wanted_size(folder: Path) -> None:
    run(folder / "view.png", folder, question=None, highlight=[11], size="800x500")
    assert cv2.imread(str(folder / "view.png")).shape == (500, 800, 3)


def test_what_view_cannot_do_is_told(folder: Path) -> None:
    with pytest.raises(UserError, match="--highlight 99"):
        run(folder / "view.png", folder, question=None, highlight=[99])
    with pytest.raises(UserError, match="cannot be asked"):
        run(folder / "view.png", folder, question="mug", highlight=None)
    with pytest.raises(UserError, match="could not be written"):
        write_png(np.zeros((4, 4, 3), np.uint8), folder / "view.unknown")


@pytest.mark.parametrize("text", ["", "1600", "1600 x 1000", "axb", "1x2"])
def test_a_size_is_width_x_height(text: str) -> None:
    with pytest.raises(UserError, match="1600x1000"):
        parsed_size(text)


def test_marks_carry_what_is_known_of_an_answer(folder: Path) -> None:
    _, document = read_scene(folder)
    (mark,) = marks_of_ids(document, [11])
    assert mark.text == "11 box  p 0.40"
    answer = {"status": "found", "route": "fast", "instances": [document["instances"][0]]}
    (mark,) = marks_of_answer(answer)
    assert mark.text == "10 box  p 0.40 · fast route"
    assert marks_of_answer({"status": "not_found", "instances": []}) == []
    assert asked("a box", answer) == "“a box”: found"
    assert asked(None, None) == ""


def test_the_corners_of_a_turned_box() -> None:
    quarter = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    box = {"centre": [1.0, 2.0, 3.0], "size": [2.0, 4.0, 6.0], "rotation": quarter}
    corners = box_corners(box)
    assert np.allclose(corners.min(axis=0), [-1.0, 1.0, 0.0])
    assert np.allclose(corners.max(axis=0), [3.0, 3.0, 6.0])


def test_a_scene_without_points_cannot_be_drawn(folder: Path) -> None:
    cloud, document = read_scene(folder)
    empty = type(cloud)(
        cloud.points_world[:0], cloud.rgb[:0], cloud.instance_id[:0], VOXEL_M, cloud.up_world
    )
    with pytest.raises(UserError, match="no points"):
        scene_picture(empty, document)


def test_the_scene_graph_is_told_by_ids() -> None:
    records = [
        {"id": 1, "role": "floor"},
        {"id": 2, "role": "wall"},
        {"id": 3, "role": "object", "supported_by": 1, "inside": None},
        {"id": 4, "role": "object", "supported_by": 3, "inside": 3},
        {"id": 5, "role": "object", "supported_by": None},
    ]
    assert scene_graph(records) == {
        "structure": {"floor": [1], "wall": [2]},
        "carries": {"1": [3], "3": [4]},
        "contains": {"3": [4]},
        "unsupported": [5],
    }
