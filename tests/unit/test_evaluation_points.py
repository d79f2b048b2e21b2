"""Evaluation points of recordings and maps, and who gets which predicted instance."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from sceneq_core.evaluation.surface_votes import SurfaceVotes, SurfaceVotesParams
from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.map_folder import read_predicted_map, read_true_map
from sceneq_tools.evaluation.points_file import read_points_file
from sceneq_tools.evaluation.predictions import nearest_ids
from sceneq_tools.evaluation.readers import read_truth
from sceneq_tools.evaluation.rendered_truth import is_rendered, read_rendered
from sceneq_tools.evaluation.scannet_text import read_codes
from sceneq_tools.evaluation.true_things import read_things
from sceneq_tools.evaluation.vocabulary import SCANNET200, own_vocabulary

from support.scannet_files import write_codes

SIDE = 8
K = np.array([[100.0, 0, 3.5], [0, 100.0, 3.5], [0, 0, 1]])
EVERY = SurfaceVotesParams(voxel_m=0.01, min_votes=1, stride=1)
"""At 1 m a pixel is 1 cm: every pixel of the frames below is a point of its own."""
WALL, CHAIR, SOFA, CUP, BOX = 1, 2, 3, 4, 5


def thing(number: int, label: str, stays: list[tuple[int, object]], **more) -> dict:
    history = [{"from_frame": first, "box": box} for first, box in stays]
    record = {"id": number, "name": f"{label}_{number}", "label": label, "stuff": False}
    return {**record, "history": history, **more}


HERE = [[0, 0, 0], [1, 1, 1]]
THINGS = [
    thing(WALL, "wall", [(0, HERE)], stuff=True),
    thing(CHAIR, "Chair", [(0, HERE), (2, HERE)]),
    thing(SOFA, "sofa", [(0, HERE)], synonyms=["settee", "couch"]),
    thing(CUP, "cup", [(0, HERE), (2, None)]),
    thing(BOX, "gizmo", [(0, None), (2, HERE)]),
]


def write_rendered(
    folder: Path, images: list[np.ndarray], things: list[dict] | None = None
) -> Path:
    """Write frames of a wall 1 m away that show ``images``."""
    folder.mkdir(parents=True)
    np.savetxt(folder / "camera-intrinsics.txt", K)
    (folder / "instances.json").write_text(json.dumps({"instances": things or THINGS}))
    for number, image in enumerate(images):
        stem = f"{folder}/frame-{number:06d}"
        cv2.imwrite(f"{stem}.color.png", np.zeros((SIDE, SIDE, 3), np.uint8))
        cv2.imwrite(f"{stem}.depth.png", np.full((SIDE, SIDE), 1000, np.uint16))
        cv2.imwrite(f"{stem}.instance.png", image.astype(np.uint16))
        np.savetxt(f"{stem}.pose.txt", np.eye(4))
    return folder


def halves(left: int, right: int) -> np.ndarray:
    image = np.full((SIDE, SIDE), left)
    image[:, SIDE // 2 :] = right
    return image


def at(truth, x_m: float) -> set[int]:
    """Return the numbers of the points left (x < 0) or right of the middle."""
    return set(truth.number[np.sign(truth.points_world[:, 0]) == np.sign(x_m)].tolist())


def test_every_pixel_becomes_a_point_of_its_thing(tmp_path: Path) -> None:
    folder = write_rendered(tmp_path / "room", [halves(SOFA, WALL)])
    assert is_rendered(folder)
    truth = read_rendered(folder, EVERY)
    assert len(truth) == SIDE * SIDE
    assert at(truth, -1) == {SOFA}
    assert at(truth, 1) == {0}
    np.testing.assert_allclose(truth.points_world[:, 2], 1.0, atol=1e-6)
    assert np.abs(truth.points_world[:, :2]).max() == pytest.approx(0.035)


def test_a_sofa_is_a_couch_in_scannet200_and_a_gizmo_is_nothing(tmp_path: Path) -> None:
    truth = read_rendered(write_rendered(tmp_path / "room", [halves(SOFA, BOX)] * 3), EVERY)
    couch = SCANNET200.numbers([("couch",)])[0]
    assert set(truth.annotation(SCANNET200).label.tolist()) == {0, couch}
    assert truth.not_in(SCANNET200) == ["gizmo"]
    assert "wall" not in own_vocabulary(truth.names).classes.values()


def test_of_a_scene_that_changes_the_end_counts(tmp_path: Path) -> None:
    # The chair moves from left to right in frame 2, where the cup was, which is gone.
    frames = [halves(CHAIR, CUP)] * 2 + [halves(WALL, CHAIR)]
    truth = read_rendered(write_rendered(tmp_path / "room", frames), EVERY)
    assert at(truth, -1) == {0}
    assert at(truth, 1) == {CHAIR}
    unseen = read_rendered(write_rendered(tmp_path / "unseen", frames[:2]), EVERY)
    assert len(unseen) == 0


def test_only_every_stepth_frame_tells_the_truth(tmp_path: Path) -> None:
    frames = [halves(SOFA, WALL), halves(WALL, SOFA), halves(WALL, SOFA)]
    folder = write_rendered(tmp_path / "room", frames)
    assert at(read_rendered(folder, EVERY), -1) == {0}
    truth = read_rendered(folder, EVERY, step=3)
    assert (at(truth, -1), at(truth, 1)) == ({SOFA}, {0})
    assert truth.source.endswith("step 3)")
    codes = tmp_path / "codes.txt"
    codes.write_text("1001\n")
    with pytest.raises(UserError, match="a step of 2 needs the frames"):
        read_truth(codes, step=2)


def test_the_majority_wins_and_the_lowest_number_among_equals(tmp_path: Path) -> None:
    frames = [halves(SOFA, SOFA)] * 2 + [halves(WALL, CHAIR)] * 2
    truth = read_rendered(write_rendered(tmp_path / "room", frames), EVERY)
    assert at(truth, -1) == {0}
    assert at(truth, 1) == {CHAIR}
    one_more = read_rendered(write_rendered(tmp_path / "more", [*frames, frames[0]]), EVERY)
    assert at(one_more, 1) == {SOFA}


def test_few_votes_and_far_pixels_are_noise() -> None:
    depth_m = np.full((SIDE, SIDE), 1.0, np.float32)
    depth_m[:, :4] = 5.0
    votes = SurfaceVotes(SurfaceVotesParams(voxel_m=0.01, min_votes=2, stride=1))
    number, may_vote = np.ones((SIDE, SIDE), np.int64), np.ones((SIDE, SIDE), bool)
    votes.add(depth_m, number, may_vote, K, np.eye(4))
    assert len(votes.points()[0]) == 0
    votes.add(depth_m, number, may_vote, K, np.eye(4))
    points_world, found = votes.points()
    assert len(points_world) == SIDE * SIDE // 2
    assert (found == 1).all()
    assert votes.points()[0].tobytes() == points_world.tobytes()


def test_votes_beyond_the_world_are_refused() -> None:
    far = np.eye(4)
    far[0, 3] = 1e6
    one = np.ones((1, 1))
    with pytest.raises(ValueError, match="voxels from the origin"):
        SurfaceVotes(EVERY).add(one, one.astype(int), one > 0, K, far)
    with pytest.raises(ValueError, match="voxel_m"):
        SurfaceVotesParams(voxel_m=0)


def test_a_wrong_recording_is_named_with_its_file(tmp_path: Path) -> None:
    folder = write_rendered(tmp_path / "room", [halves(SOFA, WALL)] * 2)
    (folder / "frame-000001.instance.png").unlink()
    with pytest.raises(UserError, match=r"frame-000001\.instance\.png: missing"):
        read_rendered(folder)
    cv2.imwrite(f"{folder}/frame-000001.instance.png", np.zeros((3, 3), np.uint16))
    with pytest.raises(UserError, match="frame 1"):
        read_rendered(folder)
    cv2.imwrite(f"{folder}/frame-000001.instance.png", np.zeros((3, 3, 3), np.uint8))
    with pytest.raises(UserError, match="expected grey uint16"):
        read_rendered(folder)
    (folder / "frame-000000.depth.png").write_bytes(b"gone")
    with pytest.raises(UserError, match=r"frame-000000\.depth\.png"):
        read_rendered(folder)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[]", "no list 'instances'"),
        ('{"instances": [{"id": 1}]}', r"instances\[0\]: no field 'history'"),
        ('{"instances": [{"id": 1, "history": []}]}', r"instances\[0\]: list index"),
        ('{"instances": [{"history": [{"box": null}]}]}', r"instances\[0\]: no field 'id'"),
    ],
)
def test_wrong_things_are_named_with_their_field(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "instances.json"
    path.write_text(text)
    with pytest.raises(UserError, match=said):
        read_things(path)


def write_points(folder: Path, **arrays) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "instances.json").write_text(json.dumps({"instances": THINGS}))
    path = folder / "eval_points.npz"
    np.savez(path, **arrays)
    return path


def test_points_that_somebody_chose(tmp_path: Path) -> None:
    points = np.arange(9.0).reshape(3, 3)
    arrays = {"points": points, "instance": np.array([SOFA, WALL, CHAIR])}
    path = write_points(tmp_path, **arrays, stuff=np.array([False, True, False]))
    truth = read_truth(path)
    assert truth.number.tolist() == [SOFA, 0, CHAIR]
    assert [truth.names[n] for n in truth.name] == [("sofa", "settee", "couch"), (), ("Chair",)]
    with pytest.raises(UserError, match="stuff"):
        read_points_file(write_points(tmp_path, **arrays))
    with pytest.raises(UserError, match=r"instance: expected \(N,\)"):
        read_points_file(write_points(tmp_path, points=points, instance=[1], stuff=[True] * 3))


def write_map(folder: Path, points: np.ndarray, ids: list[int], records: list[dict]) -> Path:
    folder.mkdir(parents=True)
    arrays = {"points": points.astype(np.float32), "instance_id": np.array(ids, np.int32)}
    np.savez(folder / "instances.npz", **arrays)
    document = {"voxel_size_m": 0.02, "up_world": [0, 0, 1], "instances": records}
    (folder / "instances.json").write_text(json.dumps(document))
    return folder


LINE = np.array([[0.0, 0, 0], [0.1, 0, 0], [0.2, 0, 0], [0.3, 0, 0]])
NEAR = np.array([0, 0.03, 0])
RECORDS = [{"id": 7, "label": "chair", "p": 0.4}, {"id": 9, "label": None, "p": 0.0}]


def test_points_take_the_nearest_instance_within_reach(tmp_path: Path) -> None:
    folder = write_map(tmp_path / "map", LINE, [7, 7, 9, 0], RECORDS)
    truth = read_true_map(write_map(tmp_path / "gt", LINE + NEAR, [1, 1, 2, 2], []))
    masks = read_predicted_map(folder).masks(truth, SCANNET200, 0.05)
    assert list(zip(masks.mask, masks.point, strict=True)) == [(0, 0), (0, 1), (1, 2)]
    assert masks.label.tolist() == [2, 0]
    assert masks.score.tolist() == [0.4, 0.0]
    assert read_predicted_map(folder, constant_score=True).score.tolist() == [1.0, 1.0]
    assert len(read_predicted_map(folder).masks(truth, SCANNET200, 0.02).point) == 0
    assert nearest_ids(LINE[:0], np.zeros(0, np.int64), LINE, 1.0).tolist() == [0] * 4


def test_instances_without_a_label_are_objects_of_a_true_map(tmp_path: Path) -> None:
    truth = read_true_map(write_map(tmp_path / "gt", LINE, [7, 9, -1, 4], RECORDS))
    assert truth.number.tolist() == [7, 9, 0, 0]
    assert set(own_vocabulary(truth.names).classes.values()) == {"chair", "nameless"}


def test_a_map_cannot_be_judged_without_coordinates(tmp_path: Path) -> None:
    folder = write_map(tmp_path / "map", LINE, [7, 7, 9, 0], RECORDS)
    truth = read_codes(write_codes(tmp_path / "gt.txt", [0, 0, 2001, 2001]))
    with pytest.raises(UserError, match="without coordinates"):
        read_predicted_map(folder).masks(truth, SCANNET200, 0.05)
