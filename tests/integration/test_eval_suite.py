"""`sceneq eval suite` over two tiny rooms and a recording, as a person types it."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from sceneq_tools.cli import app
from sceneq_tools.errors import UserError
from sceneq_tools.synth import SynthParams

from support.live_graph import write_graph
from support.tiny_suite import FRAMES, write_room, write_suite

pytestmark = pytest.mark.integration


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("suite")
    write_suite(place / "rooms")
    write_room(SynthParams(frames=FRAMES), place / "mine")
    (place / "mine" / "queries.json").unlink()
    write_graph(place, place / "mine")
    return place


def evaluated(place: Path) -> dict:
    folders = [str(place / "rooms"), str(place / "mine")]
    options = ["--segmenter", "files", "--every", "1", "--quiet"]
    files = ["--graph", str(place / "graph.yaml"), "--out", str(place / "report")]
    done = CliRunner().invoke(app, ["eval", "suite", *folders, *options, *files])
    assert (done.exit_code, done.exception) == (0, None)
    assert "own-labels" in done.stdout
    return json.loads((place / "report" / "report.json").read_text())


def test_everything_is_measured_and_maps_are_kept(place: Path) -> None:
    document = evaluated(place)
    names = [one["name"] for one in document["recordings"]]
    assert names == ["tuning_office_1", "test_kitchen_2", "mine"]
    assert [one["keyframes"] for one in document["recordings"]] == [FRAMES] * 3
    assert [one["questions"] for one in document["recordings"]] == [4, 4, 0]
    assert not any(one["map"]["was_there"] for one in document["recordings"])
    agnostic = {p["protocol"]: p for p in document["instances"]["test"]["protocols"]}["agnostic"]
    assert agnostic["ap50"] > 0.5  # by true masks
    assert document["fitted"]["recordings"] == ["tuning_office_1"]
    settings = {(one["split"], one["setting"]) for one in document["retrieval"]}
    assert settings == {
        *((split, "configured") for split in ("tuning", "test", "given")),
        *((split, "fitted") for split in ("test", "given")),
    }
    for one in document["retrieval"]:
        counted = sum(n for route in one["routes"].values() for n in route.values())
        assert counted == (0 if one["split"] == "given" else 4)
    splits = [one["split"] for one in document["calibration"]]
    assert splits == [*["test"] * 2, *["given"] * 2, *["test and given"] * 2]
    page = (place / "report" / "report.html").read_text()
    assert page.count("data:image/jpeg") >= 3
    assert json.loads((place / "report" / "calibration.json").read_text())["encoder"] == "hash-v1"

    again = evaluated(place)
    assert all(one["map"]["was_there"] for one in again["recordings"])
    assert again["instances"] == document["instances"]


def test_what_is_no_suite_is_an_error(place: Path) -> None:
    done = CliRunner().invoke(app, ["eval", "suite", str(place)])
    assert isinstance(done.exception, UserError)
    assert "neither a suite nor a recording with truth" in str(done.exception)
