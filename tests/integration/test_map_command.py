"""`sceneq map` as a person types it."""

import json
import re
import sys
from pathlib import Path

import pytest

from support.live_graph import run, write_graph
from support.recording import write_recording

pytestmark = pytest.mark.integration


def sceneq_map(*arguments: str) -> "tuple[int, str, str]":
    done = run(sys.executable, "-m", "sceneq_tools", "map", *arguments)
    return done.returncode, done.stdout, done.stderr


def test_without_poses_the_map_is_made_on_estimated_ones(tmp_path: Path) -> None:
    recording = write_recording(tmp_path / "room", frames=40)
    graph = str(write_graph(tmp_path, recording))
    options = ("--graph", graph, "--no-poses", "--report", "--rrd")
    code, printed, errors = sceneq_map(str(recording), str(tmp_path / "out"), *options)
    assert code == 0, errors
    rmse_m, frames = re.search(r"RMSE ([\d.]+) m .* (\d+) frames", printed).groups()
    assert float(rmse_m) < 0.3  # small images of few things: the odometry has little to hold on to
    assert frames == "40"
    written = {path.name for path in (tmp_path / "out").iterdir()}
    names = {"instances.npz", "instances.json", "cloud.ply", "instances.png", "scene.rrd"}
    assert written == names
    document = json.loads((tmp_path / "out" / "instances.json").read_text())
    assert document["scene"] == "room"
    assert document["instance_count"] >= 5


@pytest.mark.parametrize(
    ("missing", "complaint"),
    [("camera-intrinsics.txt", "camera-intrinsics.txt"), ("", "no frames")],
)
def test_a_folder_that_cannot_be_read_is_one_line_and_code_2(
    tmp_path: Path, missing: str, complaint: str
) -> None:
    folder = tmp_path / "room"
    if missing:
        (write_recording(folder, frames=2) / missing).unlink()
    else:
        folder.mkdir()
    graph = str(write_graph(tmp_path, folder))
    code, printed, errors = sceneq_map(str(folder), str(tmp_path / "out"), "--graph", graph)
    assert (code, printed) == (2, "")
    assert complaint in errors
    assert len(errors.splitlines()) == 1
