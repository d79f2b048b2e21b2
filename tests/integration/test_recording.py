"""A run recorded by a process of its own, killed, played again: the same map."""

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from mcap.reader import make_reader

from sceneq_nodes._backends import build

from support.live_graph import LiveGraph, run, write_graph
from support.recording import write_recording
from support.room import Room

pytestmark = pytest.mark.integration

FRAMES = 12


@pytest.fixture(scope="module")
def runtime() -> Iterator[Path]:
    """A short path: a unix socket lives in it."""
    with tempfile.TemporaryDirectory(prefix="sq") as folder:
        yield Path(folder)


@pytest.fixture(scope="module")
def graph(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("graph")
    room = Room(size=(160, 120), focal_px=130.0)
    write_recording(folder / "room", frames=FRAMES, room=room)
    return write_graph(folder, folder / "room")


def digest(live: LiveGraph, out: Path) -> str:
    done = live.sceneq("export", str(out))
    assert done.returncode == 0, done.stderr
    return json.loads((out / "instances.json").read_text())["digest"]


@pytest.fixture(scope="module")
def recorded(graph: Path, runtime: Path) -> tuple[Path, str]:
    """A recording whose recorder was killed at the end, and the digest of the map it saw."""
    file = graph.parent / "run.mcap"
    live = LiveGraph(graph, graph.parent / "room", runtime, "--record", str(file))
    try:
        live.wait_until_settled()
        live.wait(lambda: live.value("recorder", "keyframes") == FRAMES)
        refused = live.sceneq("replay", str(graph.parent / "run.mcap"))
        assert (refused.returncode, refused.stdout) == (2, "")
        assert "the graph has a source of its own" in refused.stderr
        was = digest(live, graph.parent / "live")
        os.kill(live.pids()["recorder"], signal.SIGKILL)
        return file, was
    finally:
        live.close()


def test_the_map_of_a_recording_is_the_one_that_was_recorded(
    recorded: tuple[Path, str], graph: Path, tmp_path: Path
) -> None:
    file, was = recorded
    mapped = run(
        sys.executable, "-m", "sceneq_tools", "map",
        str(file), str(tmp_path / "map"), "--graph", str(graph),
    )  # fmt: skip
    assert mapped.returncode == 0, mapped.stderr
    document = json.loads((tmp_path / "map" / "instances.json").read_text())
    assert document["digest"] == was
    assert document["instance_count"] >= 5
    assert document["scene"] == "run"


def test_a_killed_recorder_leaves_every_keyframe(recorded: tuple[Path, str]) -> None:
    file, _ = recorded
    source = build("source", {"kind": "mcap", "path": str(file)})
    assert [frame.seq for frame in source.frames()] == list(range(FRAMES))


def test_replay_brings_the_same_map_into_a_running_graph(
    recorded: tuple[Path, str], graph: Path, runtime: Path, tmp_path: Path
) -> None:
    """...while somebody records it once more."""
    file, was = recorded
    live = LiveGraph(graph, None, runtime, "--without", "ingest", "--scene", "room")
    command = ["record", str(tmp_path / "again.mcap"), "--connect", live.endpoint]
    try:
        live.wait(lambda: live.is_up("routing"))
        recorder = subprocess.Popen([sys.executable, "-m", "sceneq_tools", *command])
        mine = f"recorder-{recorder.pid}"
        try:
            live.wait(lambda: mine in live.heard() and live.heard()[mine].state == "ready")
            played = live.sceneq("replay", str(file), "--rate", "0")
            assert played.returncode == 0, played.stderr
            assert digest(live, tmp_path / "again") == was
            live.wait(lambda: live.heard()[mine].values.get("keyframes") == FRAMES)
        finally:
            recorder.send_signal(signal.SIGINT)
            assert recorder.wait(60) == 0
    finally:
        assert live.close() == 0
    with (tmp_path / "again.mcap").open("rb") as written:
        summary = make_reader(written).get_summary()
    topics = {channel.topic: number for number, channel in summary.channels.items()}
    assert summary.statistics.channel_message_counts[topics["/sceneq/keyframe"]] == FRAMES
    assert "/sceneq/map" in topics
