"""`sceneq eval changes` on a room of which somebody takes and moves things."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from sceneq_tools.cli import app
from sceneq_tools.errors import UserError

from support.questioned import IDS, write_questioned
from support.recording import write_recording
from support.room import THINGS, Room

pytestmark = pytest.mark.integration

PASS = 30
PERIOD_S = 0.5
TAKEN, MOVED = "red ball", "green box"
MOVED_TO = (1.6, 1.4, 0.25)


def edited() -> Room:
    """Return the room without one thing and with another elsewhere."""
    away = (0.0, -50.0, 0.0)
    place = {TAKEN: away, MOVED: MOVED_TO}
    return Room(tuple(replace(one, centre=place.get(one.name, one.centre)) for one in THINGS))


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two walks through the room, edited in between, with the truth of both."""
    folder = write_questioned(tmp_path_factory.mktemp("data") / "room", frames=PASS)
    second = write_recording(folder.parent / "second", PASS, edited())
    for path in second.glob("frame-*.mask.png"):
        path.rename(path.with_name(path.name.replace("mask", "instance")))
    for path in second.glob("frame-*"):
        number = int(path.name[6:12]) + PASS
        shutil.move(path, folder / f"frame-{number:06d}{path.name[12:]}")
    for path in folder.glob("frame-*.instance.png"):
        shutil.copy(path, path.with_name(path.name.replace("instance", "mask")))
    np.savetxt(folder / "stamps.txt", np.arange(2 * PASS) * PERIOD_S)
    _write_history(folder / "instances.json")
    return folder


def _write_history(path: Path) -> None:
    document = json.loads(path.read_text())
    later = {IDS[TAKEN]: None, IDS[MOVED]: [[1.35, 1.15, 0.0], [1.85, 1.65, 0.5]]}
    for record in document["instances"]:
        if record["id"] in later:
            record["history"].append({"from_frame": PASS, "box": later[record["id"]]})
    document["segments"] = [{"first": 0}, {"first": PASS}]
    path.write_text(json.dumps(document))


def test_every_edit_is_told_and_whether_the_map_knows(recording: Path, tmp_path: Path) -> None:
    options = ["--segmenter", "files", "--step", "1", "--quiet"]
    written = tmp_path / "changes.json"
    command = ["eval", "changes", str(recording), *options, "--json", str(written)]
    done = CliRunner().invoke(app, command)
    assert (done.exit_code, done.exception) == (0, None)
    assert "2 of 2 edits known" in done.stdout
    assert " 0 lost" in done.stdout
    (cut,) = json.loads(written.read_text())["cuts"]
    things = {one["name"]: one for one in cut["things"]}
    assert cut["frame"] == PASS
    assert (things[TAKEN]["kind"], things[TAKEN]["known"]) == ("vanished", True)
    assert (things[MOVED]["kind"], things[MOVED]["known"]) == ("moved", True)
    assert things[MOVED]["after"][1] > 0.5
    assert things["blue box"]["kind"] == "stayed"


def test_a_recording_in_which_nothing_changes_is_refused(tmp_path: Path) -> None:
    folder = write_questioned(tmp_path / "room", frames=2)
    done = CliRunner().invoke(app, ["eval", "changes", str(folder)])
    assert isinstance(done.exception, UserError)
    assert "no list of segments" in str(done.exception)
