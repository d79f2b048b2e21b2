"""ScanNet's files of truth and predictions, right and wrong ones."""

from pathlib import Path

import numpy as np
import pytest

from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.ply import read_vertices
from sceneq_tools.evaluation.readers import read_truth
from sceneq_tools.evaluation.scannet_scene import read_scannet
from sceneq_tools.evaluation.scannet_text import read_codes, read_predicted_text
from sceneq_tools.evaluation.vocabulary import SCANNET200, own_vocabulary

from support.scannet_files import CODES, GROUPS, POINTS, write_codes, write_masks, write_scene

FULL = np.ones(4, int)


def test_a_scene_is_what_its_annotation_says(tmp_path: Path) -> None:
    truth = read_truth(write_scene(tmp_path / "scans"))
    np.testing.assert_array_equal(truth.points_world, POINTS)
    annotation = truth.annotation(SCANNET200)
    # Wall has a number, and no class in the benchmark.
    assert annotation.number.tolist() == [code % 1000 for code in CODES]
    assert annotation.label.tolist() == [0] * 10 + [10] * 10 + [0] * 10
    assert own_vocabulary(truth.names).classes == {1: "office chair"}


def test_a_scene_is_the_same_as_its_codes(tmp_path: Path) -> None:
    scene = read_scannet(write_scene(tmp_path / "scans")).annotation(SCANNET200)
    codes = read_codes(write_codes(tmp_path / "gt.txt", CODES)).annotation(SCANNET200)
    np.testing.assert_array_equal(scene.label, codes.label)
    np.testing.assert_array_equal(scene.number, codes.number)


def test_a_raw_name_that_the_table_does_not_know_has_no_label(tmp_path: Path) -> None:
    groups = [{"objectId": 4, "segments": [9], "label": "gizmo"}]
    truth = read_scannet(write_scene(tmp_path / "scans", groups=groups))
    assert truth.number.tolist() == [0] * 20 + [5] * 10
    assert (truth.annotation(SCANNET200).label == 0).all()


@pytest.mark.parametrize(
    ("suffix", "text", "said"),
    [
        ("_vh_clean_2.0.010000.segs.json", None, "segs.json: No such file"),
        ("_vh_clean_2.0.010000.segs.json", "{", "segs.json: no JSON"),
        ("_vh_clean_2.0.010000.segs.json", "{}", "segIndices: missing"),
        ("_vh_clean_2.0.010000.segs.json", '{"segIndices": [1]}', "the mesh has 30 points"),
        ("_vh_clean_2.0.010000.segs.json", '{"segIndices": 3}', "segIndices: expected a list"),
        ("_vh_clean_2.0.010000.segs.json", '{"segIndices": ["a"]}', "segs.json: segIndices"),
        (".aggregation.json", None, "aggregation.json: No such file"),
        (".aggregation.json", "{}", "segGroups: missing"),
        (".aggregation.json", '{"segGroups": [{"objectId": 1}]}', r"segGroups\[0\].segments"),
        (".aggregation.json", '{"segGroups": [{"segments": []}]}', r"segGroups\[0\].objectId"),
        (
            ".aggregation.json",
            '{"segGroups": [{"segments": [], "objectId": 1}]}',
            r"segGroups\[0\].label: missing",
        ),
        ("_vh_clean_2.ply", "solid", "vh_clean_2.ply: header: no PLY"),
    ],
)
def test_a_wrong_file_is_named_with_its_field(
    suffix: str, text: str | None, said: str, tmp_path: Path
) -> None:
    folder = write_scene(tmp_path / "scans")
    path = folder / f"{folder.name}{suffix}"
    path.unlink() if text is None else path.write_text(text)
    with pytest.raises(UserError, match=said):
        read_scannet(folder)


def test_the_label_table_is_looked_for_above_and_checked(tmp_path: Path) -> None:
    folder = write_scene(tmp_path / "scans")
    table = tmp_path / "scans" / "scannetv2-labels.combined.tsv"
    table.rename(tmp_path / table.name)
    assert (read_scannet(folder).annotation(SCANNET200).label == 10).sum() == 10
    (tmp_path / table.name).write_text("raw_category\tnyu40id\nwall\t1\n")
    with pytest.raises(UserError, match=r"combined\.tsv: no column 'id'"):
        read_scannet(folder)
    (tmp_path / table.name).write_text("raw_category\tid\nwall\tone\n")
    with pytest.raises(UserError, match=r"combined\.tsv: column 'id'"):
        read_scannet(folder)
    (tmp_path / table.name).unlink()
    with pytest.raises(UserError, match=r"combined\.tsv: no such file"):
        read_scannet(folder)


def test_the_other_name_of_the_aggregation_is_found(tmp_path: Path) -> None:
    folder = write_scene(tmp_path / "scans", groups=GROUPS)
    old = folder / f"{folder.name}.aggregation.json"
    old.rename(folder / f"{folder.name}_vh_clean.aggregation.json")
    assert len(read_scannet(folder)) == len(POINTS)


def test_ply_in_text_is_read_too(tmp_path: Path) -> None:
    head = "ply\nformat ascii 1.0\nelement vertex 2\n"
    head += "property double z\nproperty double x\nproperty double y\nend_header\n"
    path = tmp_path / "cloud.ply"
    path.write_text(head + "3 1 2\n6 4 5\n")
    assert read_vertices(path).tolist() == [[1, 2, 3], [4, 5, 6]]


@pytest.mark.parametrize(
    ("head", "said"),
    [
        ("format ascii 1.0\nelement vertex 3\nproperty float x", "property y: missing"),
        ("format ascii 1.0\nelement face 3\nproperty float x", "element vertex: must come first"),
        ("format odd 1.0\nelement vertex 3\nproperty float x", "format: expected"),
        ("format ascii 1.0\nelement vertex 3\nproperty list uchar int x", "property x: expected"),
        (
            "format binary_little_endian 1.0\nelement vertex 3\n"
            "property float x\nproperty float y\nproperty float z",
            "element vertex: 3 expected, the file is cut off",
        ),
    ],
)
def test_ply_that_does_not_hold_what_it_says(head: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "cloud.ply"
    path.write_text(f"ply\n{head}\nend_header\n1 2 3\n")
    with pytest.raises(UserError, match=said):
        read_vertices(path)


def test_predictions_are_read_in_the_order_of_their_lines(tmp_path: Path) -> None:
    masks = [(np.array([0, 1, 1, 0]), 2, 0.25), (np.array([7, 0, 0, 0]), 77777, 1.0)]
    found = read_predicted_text(write_masks(tmp_path / "scene.txt", masks))
    assert found.mask.tolist() == [0, 0, 1]
    assert found.point.tolist() == [1, 2, 0]
    assert found.names == (("chair",), ())
    assert found.score.tolist() == [0.25, 1.0]
    assert found.count == 4


def test_an_empty_list_of_predictions_is_one(tmp_path: Path) -> None:
    found = read_predicted_text(write_masks(tmp_path / "scene.txt", []))
    truth = read_codes(write_codes(tmp_path / "gt.txt", CODES))
    assert len(found.masks(truth, SCANNET200, 0.05)) == 0


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("masks/scene_000.txt 2", "line 2: expected 'mask_path label_id score'"),
        ("masks/scene_000.txt chair 0.5", "line 2: label_id: not an integer: 'chair'"),
        ("masks/scene_000.txt 2 high", "line 2: score: not a number: 'high'"),
        ("masks/scene_000.txt 2 nan", "line 2: score: not finite"),
        ("masks/none.txt 2 0.5", "none.txt: No such file"),
        ("masks/short.txt 2 0.5", r"short.txt has 1 points, scene_000.txt has 4"),
        ("masks/words.txt 2 0.5", "words.txt, line 2: not an integer: 'no'"),
    ],
)
def test_a_wrong_prediction_is_named_with_its_line(line: str, said: str, tmp_path: Path) -> None:
    path = write_masks(tmp_path / "scene.txt", [(FULL, 2, 0.5)])
    (tmp_path / "masks" / "short.txt").write_text("1\n")
    (tmp_path / "masks" / "words.txt").write_text("1\nno\n")
    with path.open("a") as file:
        file.write(f"{line}\n")
    with pytest.raises(UserError, match=said):
        read_predicted_text(path)


def test_wrong_codes_are_named_with_their_line(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"gt\.txt, line 2: code: expected 0 or more, got -5"):
        read_codes(write_codes(tmp_path / "gt.txt", [1, -5]))
    with pytest.raises(UserError, match="No such file"):
        read_codes(tmp_path / "none.txt")


def test_masks_must_be_about_the_points_of_the_truth(tmp_path: Path) -> None:
    found = read_predicted_text(write_masks(tmp_path / "scene.txt", [(FULL, 2, 0.5)]))
    truth = read_codes(write_codes(tmp_path / "gt.txt", CODES))
    with pytest.raises(UserError, match=r"masks of 4 points, but the truth .* has 30"):
        found.masks(truth, SCANNET200, 0.05)
