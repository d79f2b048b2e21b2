"""The viewer beside a running graph: whatever it does, the graph does not wait for it."""

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.live_graph import LiveGraph, run, write_graph
from support.recording import write_recording
from support.rerun_file import contents
from support.room import Room

pytestmark = pytest.mark.integration
FRAMES = 12


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    room = Room(size=(320, 240), focal_px=260.0)
    return write_recording(tmp_path_factory.mktemp("data") / "room", frames=FRAMES, room=room)


@pytest.fixture(scope="module")
def graph(tmp_path_factory: pytest.TempPathFactory, recording: Path) -> Path:
    return write_graph(tmp_path_factory.mktemp("graph"), recording)


@pytest.fixture
def runtime() -> Iterator[Path]:
    """A short path: a unix socket lives in it."""
    with tempfile.TemporaryDirectory(prefix="sq") as folder:
        yield Path(folder)


def assert_nothing_was_lost(live: LiveGraph) -> None:
    nodes = live.status()
    assert nodes["mapping"]["counters"]["frames_integrated"] == FRAMES
    others = {name: node for name, node in nodes.items() if name not in ("routing", "viewer")}
    assert {name: node["flows"]["dropped"] for name, node in others.items()} == dict.fromkeys(
        others, 0
    )


@pytest.fixture
def paused(graph: Path, recording: Path, runtime: Path, tmp_path: Path) -> Iterator[LiveGraph]:
    """A graph whose viewer is stopped as soon as it is there and never takes anything."""
    patient = tmp_path / "graph.yaml"
    patient.write_text(graph.read_text() + "watchdog: {silent_s: 300.0}\n")
    live = LiveGraph(patient, recording, runtime, "--viewer", str(tmp_path / "a.rrd"))
    try:
        pid = live.wait(lambda: live.pids().get("viewer"))
        os.kill(pid, signal.SIGSTOP)
        yield live
        os.kill(pid, signal.SIGCONT)
    finally:
        assert live.close() == 0


def test_a_viewer_that_takes_nothing_holds_nobody_up(paused: LiveGraph) -> None:
    paused.wait_until_settled()
    assert_nothing_was_lost(paused)
    assert paused.zenoh_get("sceneq/query/room/instances?q=red ball;k=1")[0]["instances"]


def test_a_viewer_joins_a_running_graph_and_writes_what_it_sees(
    graph: Path, recording: Path, runtime: Path, tmp_path: Path
) -> None:
    live = LiveGraph(graph, recording, runtime)
    path = tmp_path / "late.rrd"
    try:
        live.wait_until_settled()
        live.sceneq("ask", "red ball")
        command = ["viewer", "--save", str(path), "--router", live.endpoint]
        viewer = subprocess.Popen([sys.executable, "-m", "sceneq_tools", *command])
        try:
            mine = f"viewer-{viewer.pid}"
            live.wait(lambda: live.status().get(mine, {}).get("values", {}).get("boxes", 0) >= 5)
            live.wait(lambda: path.stat().st_size > 10_000)
        finally:
            viewer.send_signal(signal.SIGINT)
            assert viewer.wait(10) == 0
        assert_nothing_was_lost(live)
    finally:
        assert live.close() == 0
    shown = contents(path)
    assert {"/world/colour/0", "/world/boxes", "/world/answer"} <= set(shown.entities)
    assert "red ball" in shown.texts("/answers/text")[-1]
    assert "/answers/evidence/1" in shown.entities


def test_the_option_is_checked_before_anything_starts(graph: Path, recording: Path) -> None:
    options = ["--source", str(recording), "--viewer", "picture.png"]
    done = run(sys.executable, "-m", "sceneq_tools", "up", str(graph), *options)
    assert done.returncode == 2
    assert done.stderr.startswith("sceneq: --viewer picture.png: expected serve, FILE.rrd")
