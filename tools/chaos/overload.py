"""Three times more frames than the graph can take: the map is right for those it took."""

import json
import shutil
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from sceneq_nodes._client import Client
from sceneq_nodes._database import open_to_read
from sceneq_nodes._journal import SCHEMA as JOURNAL_SCHEMA
from sceneq_nodes._journal import Journal
from sceneq_nodes._mapped import KEYFRAME
from sceneq_nodes._wire import from_bytes
from sceneq_schemas.topics import FRAME
from sceneq_tools.chaos.client_worker import ANSWERED, asked, selectors
from sceneq_tools.chaos.known import CHECKPOINTS, SCENE, settled
from sceneq_tools.chaos.live_graph import LiveGraph, write_graph
from sceneq_tools.chaos.scenario import NOTHING, Outcome, Plan
from sceneq_tools.chaos.small_recording import write_small_sample

TIMES = 3.0
LAPS, FRAMES = 3, 45
BETWEEN_S = 0.02


def run(plan: Plan) -> Iterator[Outcome]:
    """Play at three times the rate that the graph can take; then only what it took, losslessly."""
    recording = write_laps(plan.work / "all" / SCENE, plan.pick(LAPS, 1), plan.pick(FRAMES, 30))
    with playing(plan.work / "slow", recording) as graph:
        rate_hz = sustained_hz(graph)
    store = plan.work / "kept"
    rate = ("--rate", f"{TIMES * rate_hz:.2f}")
    with playing(plan.work / "fast", recording, "--store", str(store), *rate) as graph:
        with questions(graph, plan.seed) as answers:
            known = settled(graph)
        told = lost_frames(graph)
    taken = taken_frames(store / SCENE / "map" / "journal.sqlite")
    again = only(recording, plan.work / "taken" / SCENE, taken)
    with playing(plan.work / "again", again) as graph:
        same = settled(graph).digest == known.digest
        lost = NOTHING if same else "the map of these frames"
    yield judged(lost, rate_hz, len(taken), told, answers)


def judged(
    lost: str, rate_hz: float, taken: int, told: Mapping[str, int], answers: list[tuple[str, float]]
) -> Outcome:
    """Return the outcome: nothing wrong in the map, every loss counted, every question answered."""
    sent, dropped = told["sent"], sum(n for name, n in told.items() if name != "sent")
    unanswered = sum(end != ANSWERED for end, _ in answers)
    took_ms = [ms for _, ms in answers]
    counted = ", ".join(f"{name} {n}" for name, n in told.items() if name != "sent" and n)
    detail = (
        f"{sent} frames at {TIMES * rate_hz:.1f} Hz, sustainable {rate_hz:.1f} Hz: {taken} taken, "
        f"told as lost: {counted or 'none'}; {len(answers)} questions, {unanswered} unanswered, "
        f"p50 {np.percentile(took_ms, 50):.0f} ms, p99 {np.percentile(took_ms, 99):.0f} ms"
    )
    fine = lost == NOTHING and not unanswered and taken + dropped >= sent
    return Outcome(f"{TIMES:g} times the sustainable frame rate", sent, lost, fine, detail)


@contextmanager
def playing(folder: Path, recording: Path, *options: str) -> Iterator[LiveGraph]:
    """Run a graph on ``recording`` until the end of the block."""
    folder.mkdir(parents=True)
    graph = write_graph(folder, recording, mapping=CHECKPOINTS)
    with tempfile.TemporaryDirectory(prefix="sq") as runtime:
        live = LiveGraph(graph, recording, Path(runtime), *options)
        try:
            yield live
        finally:
            live.close()


def sustained_hz(graph: LiveGraph) -> float:
    """Return how many frames a second the graph takes when it is asked for each of them."""
    graph.wait(lambda: graph.value("ingest", "state") == "playing")
    began_s = time.monotonic()
    graph.wait(lambda: graph.value("ingest", "state") == "finished")
    took_s = time.monotonic() - began_s
    return int(graph.value("mapping", "keyframes") or graph.value("ingest", "keyframes")) / took_s


@contextmanager
def questions(graph: LiveGraph, seed: int) -> Iterator[list[tuple[str, float]]]:
    """Ask all the time; the list holds how each question ended and how long it took, ms."""
    ends: list[tuple[str, float]] = []
    stop = threading.Event()
    with Client(graph.endpoint, 20.0) as client:
        graph.wait(lambda: graph.value("routing", "answerable") is not None)

        def ask() -> None:
            for selector in selectors(SCENE, 100_000, str(seed)):
                if stop.wait(BETWEEN_S):
                    return
                began_s = time.perf_counter()
                end = asked(client, selector)
                ends.append((end, 1000 * (time.perf_counter() - began_s)))

        thread = threading.Thread(target=ask)
        thread.start()
        try:
            yield ends
        finally:
            stop.set()
            thread.join()


def lost_frames(graph: LiveGraph) -> dict[str, int]:
    """Return what `sceneq status` shows: frames sent, dropped by full inboxes, left unmatched."""
    nodes: dict[str, Any] = {node["node"]: node for node in json.loads(_status(graph))["nodes"]}
    return {
        "sent": nodes["ingest"]["values"]["keyframes"],
        "dropped by segmentation": nodes["segmentation"]["flows"]["dropped"],
        "dropped by mapping": nodes["mapping"]["flows"]["dropped"],
        "unmatched in mapping": nodes["mapping"]["counters"].get("frames_unmatched", 0),
    }


def taken_frames(journal: Path) -> list[int]:
    """Return the numbers of the frames in a map, in the order in which they came in."""
    read = Journal(journal, open_to_read(journal, JOURNAL_SCHEMA))
    try:
        entries = [entry for entry in read.entries(0) if entry.kind == KEYFRAME]
    finally:
        read.close()
    return [from_bytes(FRAME, entry.first).seq for entry in entries]


def write_laps(folder: Path, laps: int, frames: int) -> Path:
    """Write the small sample ``laps`` times behind itself."""
    write_small_sample(folder, frames)
    for path in sorted(folder.glob("frame-*")):
        number, rest = int(path.name[6:12]), path.name[12:]
        for lap in range(1, laps):
            shutil.copy(path, folder / f"frame-{number + lap * frames:06d}{rest}")
    return folder


def only(recording: Path, folder: Path, numbers: list[int]) -> Path:
    """Write a recording of some of the frames of another one."""
    folder.mkdir(parents=True)
    shutil.copy(recording / "camera-intrinsics.txt", folder)
    for number in numbers:
        for path in recording.glob(f"frame-{number:06d}.*"):
            shutil.copy(path, folder)
    return folder


def _status(graph: LiveGraph) -> str:
    return graph.sceneq("status", "--json").stdout
