"""Names in a running graph: given on the command line, killed with, restarted with, taken back."""

import json
import os
import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from support.live_graph import LiveGraph, write_graph
from support.recording import write_recording
from support.room import Room

pytestmark = pytest.mark.integration

FRAMES = 6
NAME = "aunt Mary's ball"
LIKENESS = {
    "format": "sceneq.likeness.v1",
    "encoders": {"*": {"again": {"weights": [26.0, 18.0], "bias": -20.0}}},
}


@pytest.fixture
def runtime() -> Iterator[Path]:
    """A short path: a unix socket lives in it."""
    with tempfile.TemporaryDirectory(prefix="sq") as folder:
        yield Path(folder)


def get(live: LiveGraph, selector: str) -> dict[str, Any]:
    """Ask as a program does; {} when nobody answers (yet)."""
    replies, _ = live.client.get(selector)
    return json.loads(replies[-1][1].payload) if replies else {}


def ask(live: LiveGraph, question: str) -> dict[str, Any]:
    return get(live, f"sceneq/query/room/instances?q={question}")


def names(live: LiveGraph) -> list[dict[str, Any]]:
    return get(live, "sceneq/query/room/names").get("names", [])


def mapped(live: LiveGraph) -> bool:
    """Whether the last frame is in the map and most of it can be answered with."""
    status = get(live, "sceneq/query/room/status")
    return status.get("frame_seq") == FRAMES - 1 and status["answerable"] >= 4


def attached(live: LiveGraph) -> list[dict[str, Any]]:
    return [one for one in names(live) if one["state"] == "attached"]


def test_a_name_outlives_the_process_that_was_told_and_the_whole_graph(
    tmp_path: Path, runtime: Path
) -> None:
    room = Room(size=(160, 120), focal_px=130.0)
    recording = write_recording(tmp_path / "room", frames=FRAMES, room=room)
    (tmp_path / "likeness.json").write_text(json.dumps(LIKENESS))
    graph = write_graph(tmp_path, recording)
    routing = "{encoder: {kind: hash}, labels"
    text = graph.read_text().replace(routing, "{likeness: likeness.json, " + routing[1:])
    graph.write_text(text)
    store = ("--store", str(tmp_path / "store"))

    live = LiveGraph(graph, recording, runtime, *store)
    try:
        live.wait_until_settled()
        assert mapped(live)
        ball = ask(live, "red ball")["instances"][0]["id"]
        told = live.sceneq("teach", str(ball), NAME, "--by", "anna")
        assert told.stdout == f"instance {ball} is '{NAME}' (individual, p 0.99)\n", told.stderr
        (answer,) = live.zenoh_get(f"sceneq/query/room/instances?q=where is {NAME}")
        assert (answer["status"], answer["route"]) == ("found", "fast")
        assert answer["instances"][0]["id"] == ball
        assert answer["reason"].startswith(f"'{NAME}' was taught by anna on 20")

        old = live.pids()["routing"]
        os.kill(old, signal.SIGKILL)
        assert live.wait(lambda: attached(live))[0]["id"] == ball
        assert live.pids()["routing"] != old
        found = live.wait(lambda: ask(live, NAME).get("instances"))
        assert found[0]["id"] == ball
    finally:
        assert live.close() == 0

    live = LiveGraph(graph, recording, runtime, *store)
    try:
        (one,) = live.wait(lambda: attached(live))
        assert (one["name"], one["by"], one["kind"]) == (NAME, "anna", "individual")
        found = live.wait(lambda: ask(live, NAME).get("instances"))
        assert (found[0]["id"], found[0]["label"]) == (one["id"], NAME)
        shown = live.sceneq("ask", NAME, "--mode", "fast").stdout
        assert f"{NAME} (taught)" in shown
        gone = live.sceneq("forget", NAME)
        assert gone.stdout.startswith(f"forgotten: '{NAME}' (instance {one['id']}), taught by anna")
        assert names(live) == []
        assert live.sceneq("forget", NAME).returncode == 1
    finally:
        assert live.close() == 0
