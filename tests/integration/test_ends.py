"""Nodes that are killed come back, what was known stays known, and Ctrl-C ends everything."""

import json
import os
import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from support.live_graph import LiveGraph, write_graph
from support.shared_room import FRAMES, NODES, SharedRoom, write_room

pytestmark = [pytest.mark.integration, pytest.mark.timeout(600)]


def asked(live: LiveGraph, key: str) -> dict[str, Any]:
    """Return the answer; {} when there is none (yet)."""
    replies, _ = live.client.get(f"sceneq/query/room/{key}")
    return json.loads(replies[-1][1].payload) if replies else {}


def test_what_was_answerable_stays_so_when_its_writers_are_killed(room: SharedRoom) -> None:
    live = room.live
    live.wait_until_settled()

    def answers() -> tuple[int, int]:
        status = asked(live, "status")
        return status["instances"], status["answerable"]

    before = answers()
    assert before[1] >= 5
    for node in ("encoding", "views", "ingest"):
        old = live.pids()[node]
        os.kill(old, signal.SIGKILL)
        assert answers() == before
        live.wait(lambda node=node, old=old: live.pids()[node] != old and live.is_up(node))
        assert answers() == before
    # Ingest plays again what the map holds already: acknowledged at once, nothing changes.
    live.wait_until_settled()
    nodes = live.heard()
    assert nodes["mapping"].counters["frames_integrated"] == FRAMES
    assert nodes["mapping"].counters["frames_repeated"] >= FRAMES
    assert nodes["ingest"].counters.get("frames_lost", 0) == 0
    assert answers() == before


def test_ctrl_c_ends_the_graph(room: SharedRoom) -> None:
    assert set(NODES) < set(room.live.pids())
    assert room.live.close() == 0


@pytest.fixture
def playing(tmp_path: Path) -> Iterator[LiveGraph]:
    recording = write_room(tmp_path)
    graph = write_graph(tmp_path, recording)
    with tempfile.TemporaryDirectory(prefix="sq") as runtime:  # a short path, for sockets
        live = LiveGraph(graph, recording, Path(runtime), "--loop", "--rate", "5")
        try:
            live.wait(lambda: asked(live, "status").get("answerable"))
            yield live
        finally:
            assert live.close() == 0


def test_a_killed_node_comes_back_and_queries_work_again(playing: LiveGraph) -> None:
    for node in NODES:
        before = playing.pids()
        os.kill(before[node], signal.SIGKILL)
        playing.wait(lambda node=node, old=before[node]: playing.pids()[node] != old)
        playing.wait(lambda node=node: playing.is_up(node))
        playing.wait(lambda: asked(playing, "instances?q=red ball"))
        after = playing.pids()
        untouched = set(NODES) - {node}
        assert [after[n] for n in untouched] == [before[n] for n in untouched], (
            playing.log.read_text()
        )
