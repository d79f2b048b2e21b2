"""Nodes killed at random moments: the map, its views and the answers are the undisturbed run's.

Four kills by default; ``SCENEQ_KILLS=50 SCENEQ_SEED=7 pytest tests/integration/test_kills.py``
does more, other ones.
"""

import json
import os
import random
import signal
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from support.live_graph import LiveGraph, write_graph
from support.recording import write_recording
from support.room import Room

pytestmark = [pytest.mark.integration, pytest.mark.timeout(3600)]

VICTIMS = ("mapping", "views", "encoding", "routing")
KILLS = int(os.environ.get("SCENEQ_KILLS", "4"))
SEED = int(os.environ.get("SCENEQ_SEED", "0"))
KILLS_A_RUN = 5
QUESTIONS = ("red ball", "blue box", "table", "wall")
FRAMES = 12


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    room = Room(size=(320, 240), focal_px=260.0)
    return write_recording(tmp_path_factory.mktemp("data") / "room", frames=FRAMES, room=room)


@pytest.fixture(scope="module")
def graph(tmp_path_factory: pytest.TempPathFactory, recording: Path) -> Path:
    return write_graph(tmp_path_factory.mktemp("graph"), recording)


@pytest.fixture(scope="module")
def runtime() -> Iterator[Path]:
    """A short path: a unix socket lives in it."""
    with tempfile.TemporaryDirectory(prefix="sq") as folder:
        yield Path(folder)


@pytest.fixture(scope="module")
def undisturbed(graph: Path, recording: Path, runtime: Path, tmp_path_factory: Any) -> Any:
    live = LiveGraph(graph, recording, runtime)
    try:
        live.wait_until_settled()
        return outcome(live, tmp_path_factory.mktemp("whole"))
    finally:
        assert live.close() == 0


def outcome(live: LiveGraph, folder: Path) -> dict[str, Any]:
    """Return what a reader can know: the map and what is said of it, and answers."""
    exported = live.sceneq("export", str(folder))
    assert exported.returncode == 0, exported.stderr
    told = json.loads((folder / "instances.json").read_text())
    return {"digest": told["digest"], "instances": told["instances"], "answers": answers(live)}


def answers(live: LiveGraph) -> list[Any]:
    found = [live.zenoh_get(f"sceneq/query/room/instances?q={q};k=3")[0] for q in QUESTIONS]
    return [(answer["status"], answer["instances"]) for answer in found]


def settle(live: LiveGraph) -> None:
    """Wait until everything is described, and stays so while readers hear the last of it."""
    for _ in range(2):
        live.wait_until_settled()
        time.sleep(1.5)


def kill(live: LiveGraph, victim: str) -> int:
    pid = live.pids()[victim]
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:  # on its way back from the last time
        return 0
    return 1


@pytest.mark.parametrize("run", range(-(-KILLS // KILLS_A_RUN)))
def test_killed_nodes_bring_back_what_they_knew(
    run: int, undisturbed: Any, graph: Path, recording: Path, runtime: Path, tmp_path: Path
) -> None:
    chance = random.Random(f"{SEED}-{run}")
    live = LiveGraph(graph, recording, runtime, "--store", str(tmp_path / "kept"))
    try:
        live.wait(lambda: "ingest       playing" in live.log.read_text())
        killed = 0
        while killed < min(KILLS_A_RUN, KILLS - run * KILLS_A_RUN):
            time.sleep(chance.uniform(0.0, 2.0))
            killed += kill(live, chance.choice(VICTIMS))
        settle(live)
        now = outcome(live, tmp_path / "map")
        counters = {name: node["counters"] for name, node in live.status().items()}
        assert now["digest"] == undisturbed["digest"], counters
        assert now["instances"] == undisturbed["instances"], counters
        assert now["answers"] == undisturbed["answers"], counters
    finally:
        assert live.close() == 0
