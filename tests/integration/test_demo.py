"""`sceneq demo` as a person types it."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import cv2
import pytest

from support.live_graph import write_graph
from support.recording import write_recording

pytestmark = pytest.mark.integration

PATIENCE_S = 240.0


def start(folder: Path, *arguments: str) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-m", "sceneq_tools", "demo", *arguments],
        cwd=folder,
        env=os.environ | {"NO_COLOR": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def recording(folder: Path) -> Path:
    made = write_recording(folder / "room", frames=12)
    queries = [{"text": "unicorn", "bucket": "absent", "targets": []}]
    things = [
        {
            "id": 1,
            "name": "ball_01",
            "label": "ball",
            "stuff": False,
            "history": [{"from_frame": 0, "box": [[0, 0, 0], [1, 1, 1]]}],
        }
    ]
    (made / "queries.json").write_text(json.dumps({"queries": queries}))
    (made / "instances.json").write_text(json.dumps({"instances": things}))
    return made


def test_the_demo_asks_while_the_map_grows_and_writes_what_it_found(tmp_path: Path) -> None:
    made = recording(tmp_path)
    graph = str(write_graph(tmp_path, made))
    asked = ("-q", "ball", "-q", "what's on the table")
    demo = start(tmp_path, str(made), "out", "--graph", graph, *asked)
    printed, errors = demo.communicate(timeout=PATIENCE_S)
    assert demo.returncode == 0, printed + errors
    assert errors == ""
    assert printed.count("$ zenoh --mode client --connect tcp/127.0.0.1:") == 2
    assert printed.index("While the map grows") < printed.index("The recording is over")
    assert "sceneq/query/room/ask?q=ball" in printed
    assert printed.count("“ball”") == 1
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"answers.png", "scene.rrd", "instances.npz", "instances.json"} <= written
    assert cv2.imread(str(tmp_path / "out" / "answers.png")).shape == (1000, 1600, 3)


def test_a_node_that_died_is_told_and_the_demo_fails(tmp_path: Path) -> None:
    made = recording(tmp_path)
    graph = str(write_graph(tmp_path, made))
    demo = start(tmp_path, str(made), "out", "--graph", graph, "--rate", "2")
    log = tmp_path / "out" / "graph.log"
    deadline_s = time.monotonic() + PATIENCE_S
    while not (pid := pid_of(log, "reasoning")) or "ready after" not in log.read_text():
        assert time.monotonic() < deadline_s
        time.sleep(0.1)
    os.kill(pid, signal.SIGKILL)
    printed, errors = demo.communicate(timeout=PATIENCE_S)
    assert demo.returncode == 1, printed
    assert "reasoning    was ended by SIGKILL" in errors


def test_a_folder_without_frames_is_one_line_and_code_2(tmp_path: Path) -> None:
    demo = start(tmp_path, str(tmp_path))
    printed, errors = demo.communicate(timeout=PATIENCE_S)
    assert (demo.returncode, printed) == (2, "")
    assert errors.startswith("sceneq: ")
    assert "no frames" in errors
    assert len(errors.splitlines()) == 1


def pid_of(log: Path, node: str) -> int:
    words = log.read_text().split() if log.is_file() else []
    at = [i for i, word in enumerate(words) if word == node and words[i + 1 : i + 2] == ["started"]]
    return int(words[at[0] + 3].rstrip(")")) if at else 0
