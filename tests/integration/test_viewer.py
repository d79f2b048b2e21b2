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
from support.rerun_file import contents
from support.shared_room import FRAMES, NODES, SharedRoom, write_room

pytestmark = pytest.mark.integration


def assert_nothing_was_lost(live: LiveGraph) -> None:
    nodes = live.heard()
    assert nodes["mapping"].counters["frames_integrated"] == FRAMES
    others = [name for name in NODES if name != "routing"]  # which wants the newest pose only
    assert {name: nodes[name].flows["dropped"] for name in others} == dict.fromkeys(others, 0)


@pytest.fixture
def paused(tmp_path: Path) -> Iterator[LiveGraph]:
    """A graph whose viewer is stopped as soon as it is there and never takes anything."""
    recording = write_room(tmp_path)
    patient = write_graph(tmp_path, recording)
    patient.write_text(patient.read_text() + "watchdog: {silent_s: 300.0}\n")
    with tempfile.TemporaryDirectory(prefix="sq") as runtime:  # a short path, for sockets
        live = LiveGraph(patient, recording, Path(runtime), "--viewer", str(tmp_path / "a.rrd"))
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
    room: SharedRoom, tmp_path: Path
) -> None:
    live, path = room.live, tmp_path / "late.rrd"
    live.sceneq("ask", "red ball")
    command = ["viewer", "--save", str(path), "--router", live.endpoint]
    viewer = subprocess.Popen([sys.executable, "-m", "sceneq_tools", *command])
    try:
        mine = f"viewer-{viewer.pid}"
        live.wait(lambda: has_drawn(live, mine))
        live.wait(lambda: path.exists() and path.stat().st_size > 10_000)
    finally:
        viewer.send_signal(signal.SIGINT)
        assert viewer.wait(60) == 0
    assert_nothing_was_lost(live)
    shown = contents(path)
    assert {"/world/colour/0", "/world/boxes", "/world/answer"} <= set(shown.entities)
    assert "red ball" in shown.texts("/answers/text")[-1]
    assert "/answers/evidence/1" in shown.entities


def has_drawn(live: LiveGraph, viewer: str) -> bool:
    """Whether it shows the map and an answer."""
    said = live.heard().get(viewer)
    return said is not None and said.values.get("boxes", 0) >= 5 and said.values["answer"] != ""


def test_the_option_is_checked_before_anything_starts(room: SharedRoom) -> None:
    options = ["--source", str(room.recording), "--viewer", "picture.png"]
    done = run(sys.executable, "-m", "sceneq_tools", "up", str(room.graph), *options)
    assert done.returncode == 2
    assert done.stderr.startswith("sceneq: --viewer picture.png: expected serve, FILE.rrd")
