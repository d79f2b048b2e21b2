"""``sceneq eval instances`` over all forms of predictions and truths."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from sceneq_tools.cli import app
from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.instances import InstancesParams, evaluate_instances
from sceneq_tools.evaluation.readers import scene_pairs

from support.scannet_files import CODES, POINTS, write_codes, write_masks, write_scene

CHAIR = np.array([code == 10002 for code in CODES])
OFFICE_CHAIR = 10


def report(tmp_path: Path, prediction: Path, truth: Path, *options: str) -> dict:
    """Return what the command writes as JSON."""
    out = tmp_path / "out" / "report.json"
    arguments = ["eval", "instances", str(prediction), str(truth), "--json", str(out)]
    result = CliRunner().invoke(app, [*arguments, *options], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return json.loads(out.read_text())


def by_protocol(document: dict) -> dict[str, dict]:
    return {one["protocol"]: one for one in document["protocols"]}


def write_chair_map(folder: Path) -> Path:
    """Write a map whose only instance is the chair of the ScanNet scene, 1 cm beside it."""
    folder.mkdir(parents=True)
    np.savez(folder / "instances.npz", points=POINTS + 0.01, instance_id=3 * CHAIR)
    record = {"id": 3, "label": "office chair", "p": 0.5}
    document = {"voxel_size_m": 0.02, "up_world": [0, 0, 1], "instances": [record]}
    (folder / "instances.json").write_text(json.dumps(document))
    return folder


def test_text_against_text(tmp_path: Path) -> None:
    prediction = write_masks(tmp_path / "pred.txt", [(CHAIR, OFFICE_CHAIR, 0.5)])
    truth = write_codes(tmp_path / "gt.txt", CODES)
    found = by_protocol(report(tmp_path, prediction, truth, "--min-region", "5"))
    for name in ("scannet200", "own-labels", "agnostic"):
        assert (found[name]["ap"], found[name]["objects"]) == (1.0, 1)
    # The wall has a number and the rest is one more object: one of three is found.
    assert found["maskclustering"]["objects"] == 3
    assert found["maskclustering"]["ap50"] == pytest.approx(1 / 3)
    assert found["maskclustering"]["overlaps"][-2:] == [0.9, 0.25]
    assert found["scannet200"]["splits"]["head"]["ap"] == 1.0
    assert found["scannet200"]["splits"]["tail"]["ap"] is None


def test_a_map_against_a_scannet_scene(tmp_path: Path) -> None:
    scene = write_scene(tmp_path / "scans")
    document = report(
        tmp_path, write_chair_map(tmp_path / "map"), scene, "--min-region=5", "--score=equal"
    )
    assert by_protocol(document)["scannet200"]["ap"] == 1.0
    assert (document["points"], document["score"]) == (len(POINTS), "constant")


def test_a_wrong_label_costs_only_where_labels_match(tmp_path: Path) -> None:
    prediction = write_masks(tmp_path / "pred.txt", [(CHAIR, 4, 0.5)])
    truth = write_codes(tmp_path / "gt.txt", CODES)
    found = by_protocol(report(tmp_path, prediction, truth, "--min-region", "5"))
    assert found["scannet200"]["ap"] == 0.0
    assert found["agnostic"]["ap"] == 1.0


def test_regions_below_the_minimum_do_not_count(tmp_path: Path) -> None:
    prediction = write_masks(tmp_path / "pred.txt", [(CHAIR, OFFICE_CHAIR, 0.5)])
    found = report(tmp_path, prediction, write_codes(tmp_path / "gt.txt", CODES))
    assert {one["min_region"] for one in found["protocols"]} == {100}
    assert {(one["ap"], one["objects"]) for one in found["protocols"]} == {(None, 0)}


def test_many_scenes_are_evaluated_together(tmp_path: Path) -> None:
    for name in ("scene0000_00", "scene0000_01", "scene0000_02"):
        write_scene(tmp_path / "scans", name)
    maps = tmp_path / "maps"
    write_chair_map(maps / "scene0000_00")
    write_masks(maps / "scene0000_01.txt", [])
    pairs = scene_pairs(maps, tmp_path / "scans")
    assert [(p.name, t.name) for p, t in pairs] == [
        ("scene0000_00", "scene0000_00"),
        ("scene0000_01.txt", "scene0000_01"),
    ]
    result = evaluate_instances(pairs, InstancesParams(min_region=5)).results[0]
    assert (result.scenes, result.objects, result.means[0]) == (2, 2, pytest.approx(0.5))


def test_what_is_printed_names_its_protocol(tmp_path: Path) -> None:
    prediction = write_masks(tmp_path / "pred.txt", [(CHAIR, OFFICE_CHAIR, 0.5)])
    truth = write_codes(tmp_path / "gt.txt", CODES)
    arguments = ["eval", "instances", str(prediction), str(truth), "--protocol", "scannet200"]
    options = ["--min-region", "5", "--classes", "--last-overlap", "0.90"]
    printed = CliRunner().invoke(app, [*arguments, *options], catch_exceptions=False).stdout
    assert "scannet200 to 0.90" in printed
    assert "IoU 0.50:0.05:0.90" in printed
    assert "office chair" in printed
    assert "agnostic" not in printed
    assert "regions of 5 points" in printed


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--protocol", "coco"], "expected one of scannet200"),
        (["--score", "area"], "expected p or equal"),
        (["--reach", "0"], "reach_m: must be positive"),
        (["--voxel", "-1"], "voxel_m: must be positive"),
        (["--last-overlap", "2"], "last_overlap"),
    ],
)
def test_wrong_options_are_refused(options: list[str], said: str, tmp_path: Path) -> None:
    prediction = write_masks(tmp_path / "pred.txt", [])
    arguments = ["eval", "instances", str(prediction), str(prediction), *options]
    result = CliRunner().invoke(app, arguments)
    assert isinstance(result.exception, UserError)
    assert said in str(result.exception)


def test_what_is_no_scene_is_refused(tmp_path: Path) -> None:
    prediction = write_masks(tmp_path / "pred.txt", [])
    (tmp_path / "empty").mkdir()
    with pytest.raises(UserError, match="no truth in it"):
        scene_pairs(prediction, tmp_path / "empty")
    with pytest.raises(UserError, match="no prediction in it"):
        scene_pairs(tmp_path / "empty", tmp_path)
    with pytest.raises(UserError, match="no truth named pred"):
        scene_pairs(tmp_path, tmp_path / "empty")
