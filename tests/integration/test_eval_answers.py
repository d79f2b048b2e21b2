"""`sceneq eval retrieval|calibration|ablation` and `sceneq calibrate` as a person types them."""

import io
import json
import sys
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from unittest.mock import patch

import pytest

from sceneq_tools.cli import main

from support.live_graph import run, write_graph
from support.questioned import write_questioned
from support.recording import write_recording

pytestmark = pytest.mark.integration
FRAMES = 8


def sceneq(*arguments: object) -> "tuple[int, str, str]":
    """Type a command, in this process: a new one would load more than it computes."""
    out, errors = io.StringIO(), io.StringIO()
    with (
        patch.object(sys, "argv", ["sceneq", *map(str, arguments)]),
        redirect_stdout(out),
        redirect_stderr(errors),
        pytest.raises(SystemExit) as ended,
    ):
        main()
    return int(ended.value.code or 0), out.getvalue(), errors.getvalue()


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a recording, a graph, and a map of it by true masks."""
    place = tmp_path_factory.mktemp("eval")
    recording = write_questioned(place / "room", FRAMES)
    masks = write_recording(place / "masks", FRAMES)
    write_graph(place, masks)
    code, _, errors = sceneq("map", recording, place / "map", "--graph", place / "graph.yaml")
    assert code == 0, errors
    return place


def measured(place: Path, what: str, *arguments: object) -> dict:
    out = place / f"{what}.json"
    options = ("--graph", place / "graph.yaml", "--json", out, "--quiet")
    code, printed, errors = sceneq("eval", what, *arguments, *options)
    assert (code, errors) == (0, "")
    assert printed.startswith(f"{what} in room: encoder hash-v1")
    return json.loads(out.read_text())


def test_retrieval_asks_about_the_map_and_the_truth(place):
    document = measured(place, "retrieval", place / "map", place / "room")
    results = {(one["candidates"], one["hit_rule"]): one for one in document["results"]}
    assert list(results) == [
        ("map", "IoU >= 0.5"), ("map", "IoU >= 0.25"), ("true instances", "true mask"),
    ]  # fmt: skip
    for result in results.values():
        attribute = result["buckets"][0]
        assert (attribute["bucket"], attribute["questions"]) == ("attribute", 2)
        assert sum(one["questions"] for one in result["buckets"][:-2]) == 4
    truth = results["true instances", "true mask"]
    assert truth["instances"] == 5
    assert truth["buckets"][0]["hit_1"] == 2  # colours are what this encoder knows
    found = {one["question"]: one["best"] for one in results["map", "IoU >= 0.5"]["answers"]}
    assert found["yellow ball"]
    assert results["map", "IoU >= 0.5"]["buckets"][0]["hit_1"] == 2


def test_calibration_is_fitted_used_and_told_apart(place):
    before = measured(place, "calibration", place / "room")
    choices = [task["choices"] for task in before["tasks"]]
    assert choices == ["instances", "custom", "own", *["instances"] * 3]
    out = place / "fitted.json"
    graph = ("--graph", place / "graph.yaml")
    code, _, errors = sceneq(
        *("calibrate", place / "room", *graph, "--out", out, "--date", "today", "--quiet")
    )
    assert (code, errors) == (0, "")
    fitted = json.loads(out.read_text())
    assert (fitted["encoder"], fitted["date"]) == ("hash-v1", "today")
    after = measured(place, "calibration", place / "room", "--calibration", out)
    assert after["fitted_on"] == ["room"]
    assert after["temperature"] == fitted["temperature"]
    assert after["calibration"].startswith("hash-v1:")
    assert after["tasks"][3]["nll"] <= before["tasks"][3]["nll"] + 1e-6
    assert fitted["null"]["bias"] != 0.0  # the bathtub is not there
    assert after["routing"]["claims"]["absence_auroc"] == 1.0
    fitted["encoder"] = "another"
    out.write_text(json.dumps(fitted))
    code, _, errors = sceneq("eval", "calibration", place / "room", *graph, "--calibration", out)
    assert code == 2
    assert "made for the encoder 'another', this one is 'hash-v1'" in errors


def test_the_ablation_reasons_never_sometimes_and_always(place):
    document = measured(place, "ablation", place / "room")
    reasoned = [one["buckets"][-1]["reasoned"] for one in document["results"]]
    assert reasoned[0] == 0 <= reasoned[1] <= reasoned[2] == 4


def test_policies_are_compared_on_the_same_questions(place):
    out, png = place / "policies.json", place / "policies.png"
    code, printed, errors = sceneq(
        *("eval", "ablation", place / "room", "--policies", "--simulated", "0.8"),
        *("--graph", place / "graph.yaml", "--json", out, "--png", png, "--quiet"),
    )
    assert (code, errors) == (0, "")
    assert printed.startswith("policies in room: encoder hash-v1")
    graph, model = json.loads(out.read_text())["curves"]
    assert (graph["reasoner"], model["reasoner"]) == (
        "GeometricReasoner",
        "simulated model, right 80 %",
    )
    costs = {(one["policy"], one["setting"]): one["cost"] for one in graph["points"]}
    assert costs["never", ""] == 0.0 <= costs["thresholds", "x 1"] <= costs["always", ""] == 1.0
    assert png.read_bytes().startswith(b"\x89PNG")


def test_a_recording_without_truth_is_one_line_and_code_2(place):
    done = run(sys.executable, "-m", "sceneq_tools", "eval", "retrieval", str(place / "masks"))
    assert (done.returncode, done.stdout) == (2, "")
    assert "instances.json" in done.stderr
    assert len(done.stderr.splitlines()) == 1
