"""True instances, seen and described as the graph would."""

import json
from pathlib import Path

import numpy as np
import pytest

from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.oracle import oracle

from support.questioned import IDS, hash_setup, instance_of, paint_over, write_questioned

FRAMES = 6


def look(folder: Path, every: int = 1):
    return oracle(folder, hash_setup(every), lambda n=1: None)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_questioned(tmp_path / "room", FRAMES)


def change(folder: Path, name: str, **fields: object) -> None:
    path = folder / "instances.json"
    document = json.loads(path.read_text())
    next(one for one in document["instances"] if one["name"] == name).update(fields)
    path.write_text(json.dumps(document))


def test_every_thing_but_stuff_is_a_candidate_with_its_true_box(folder):
    found = look(folder)
    assert [one.instance_id for one in found.snapshot.instances] == [3, 4, 5, 6, 7]
    assert found.unseen == ()
    ball = found.snapshot.instances[1].geometry
    assert ball.aabb_world == pytest.approx(np.array([[-0.47, 0.83, 0.72], [-0.23, 1.07, 0.96]]))
    assert ball.box_size_m == pytest.approx([0.24] * 3)


def test_views_are_the_boxes_of_the_true_masks(folder):
    snapshot = look(folder).snapshot
    for one in snapshot.instances:
        for view in one.views:
            rows, columns = np.nonzero(instance_of(view.seq, FRAMES) == one.instance_id)
            true = [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]
            assert np.abs(np.subtract(view.box_xyxy, true)).max() <= 2  # every second pixel


def test_descriptors_are_those_of_the_crops(folder):
    setup, snapshot = hash_setup(), look(folder).snapshot
    red, blue = setup.encoder.encode_texts(["red", "blue"])
    of = {one.instance_id: row for one, row in enumerate_rows(snapshot)}
    assert of[IDS["red ball"]] @ red > 0.8 > of[IDS["red ball"]] @ blue
    assert of[IDS["blue box"]] @ blue > 0.8 > of[IDS["blue box"]] @ red


def enumerate_rows(snapshot):
    return zip(snapshot.instances, snapshot.descriptors, strict=True)


def test_what_no_keyframe_shows_is_unseen(folder):
    paint_over(folder, IDS["red ball"])
    found = look(folder)
    assert found.unseen == (IDS["red ball"],)
    assert found.snapshot.find(IDS["red ball"]) is None


def test_a_thing_is_looked_at_only_where_it_stands_in_the_end(folder):
    box = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]
    change(
        folder, "red ball", history=[{"from_frame": 0, "box": box}, {"from_frame": 4, "box": box}]
    )
    change(
        folder,
        "yellow ball",
        history=[{"from_frame": 0, "box": box}, {"from_frame": 4, "box": None}],
    )
    snapshot = look(folder).snapshot
    ball = snapshot.instances[snapshot.find(IDS["red ball"])]
    assert {view.seq for view in ball.views} == {4, 5}
    assert snapshot.find(IDS["yellow ball"]) is None


def test_the_keyframes_are_those_of_the_graph(folder):
    seqs = {view.seq for one in look(folder, every=3).snapshot.instances for view in one.views}
    assert seqs == {0, 3}


def test_the_same_recording_gives_the_same_bits(folder):
    first, second = look(folder).snapshot, look(folder).snapshot
    assert np.array_equal(np.asarray(first.descriptors), np.asarray(second.descriptors))
    assert (first.viewpoint_world == second.viewpoint_world).all()


def test_a_missing_instance_image_is_named(folder):
    (folder / "frame-000002.instance.png").unlink()
    with pytest.raises(UserError, match=r"frame-000002\.instance\.png"):
        look(folder)
