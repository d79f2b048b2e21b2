"""A robot and a server on a thin link: frames across it, questions meanwhile, and the link cut.

The robot maps; the server hears every keyframe, describes instances, mirrors the map, and somebody
there asks the robot. The two machines are network namespaces: this needs root.
"""

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sceneq_tools.bench.measurement import Measurement, Options, latency, median, p99
from sceneq_tools.chaos.namespaces import Machine, NotPermittedError, Pair, two_machines
from sceneq_tools.chaos.robot_and_server import (
    EDGE,
    LOCAL,
    PULLED,
    SERVER,
    SMALL_BUFFER,
    BrokenError,
    RobotAndServer,
    machines,
    mapping_nodes,
    node,
)

LINK_MBIT_S = 20.0
FRAMES_HZ = 10.0
PULL = {"every_s": 5.0, "mbit_s": 2.0}
LEAST_S = 20.0
CUT_S = 60.0
WARM_FRAMES = 20
CATCH_UP_S = 300.0
SCENE = "room"


@dataclass(frozen=True, slots=True)
class Probed:
    """What somebody who asks and counts frames found."""

    seconds: float
    taken_ms: list[float]
    unanswered: int
    frames: int
    bytes: int


def link(options: Options) -> Iterator[Measurement]:
    """Measure questions and frames with both sizes of send buffers; then cut it for a minute.

    Raises:
        ConnectionError: this process may not make network namespaces, or the graph broke.
    """
    if options.source is None:
        raise ConnectionError("which recording? say --source FOLDER")
    seconds = max(options.seconds, LEAST_S)
    try:
        with _running(options.source, "") as (pair, _):
            alone = _probe(pair.server, seconds)
        with _running(options.source, SMALL_BUFFER) as (pair, both):
            yield from _transfer(pair, seconds, alone)
            yield from _cut(pair, both)
    except (NotPermittedError, BrokenError) as error:
        raise ConnectionError(str(error)) from error


def graph(pair: Pair, source: Path, metadata: str) -> dict[str, Any]:
    """Return the graph: the light nodes on the robot, descriptors and a mirror on the server."""
    hashed = {"encoder": {"kind": "hash"}}
    return {
        **machines(pair, metadata),
        "nodes": [
            *mapping_nodes(source, FRAMES_HZ),
            node("routing", EDGE, params={**hashed, "labels": ["chair", "table", "lamp"]}),
            node("encoding", SERVER, params=hashed),
            node(PULLED, SERVER, kind="mirror", params={"pull": PULL}),
        ],
    }


@contextmanager
def _running(source: Path, metadata: str) -> Iterator[tuple[Pair, RobotAndServer]]:
    with (
        two_machines() as pair,
        tempfile.TemporaryDirectory(prefix="sq") as work,
        RobotAndServer(pair, graph(pair, source, metadata), Path(work), (PULLED,)) as both,
    ):
        pair.limit(LINK_MBIT_S)
        both.start(EDGE)
        both.start(SERVER)
        both.wait("frames in the map", lambda: both.frames() >= WARM_FRAMES)
        yield pair, both


def _transfer(pair: Pair, seconds: float, alone: Probed) -> Iterator[Measurement]:
    here = _probe(pair.edge, seconds)
    before = pair.sent_bytes()
    there = _probe(pair.server, seconds)
    sent = [after - then for after, then in zip(pair.sent_bytes(), before, strict=True)]
    yield Measurement("frame on the link", there.bytes / max(there.frames, 1) / 1000, "kB")
    beside = "sent on the robot"
    rates = (there.frames / there.seconds, here.frames / here.seconds)
    yield Measurement("frames that arrive", rates[0], "/s", beside, rates[1])
    for way, count in zip(("to", "from"), sent, strict=True):
        rate = 8e-6 * count / there.seconds
        yield Measurement(f"{way} the server", rate, "Mbit", "the link", LINK_MBIT_S)
    yield from latency(
        "question over the link,", there.taken_ms, "large send buffer", alone.taken_ms
    )
    yield from latency("question over the link,", there.taken_ms, "on the robot", here.taken_ms)
    yield Measurement("questions not answered", there.unanswered, "")


def _cut(pair: Pair, both: RobotAndServer) -> Iterator[Measurement]:
    """The robot is asked while the link is cut; then everything is to become equal."""
    frames = both.frames()
    pair.cut()
    try:
        alone = _probe(pair.edge, CUT_S)
    finally:
        pair.heal()
    healed_s = time.monotonic()
    yield Measurement("link cut: frames mapped", both.frames() - frames, "")
    yield Measurement("link cut: question on the robot p50", median(alone.taken_ms), "ms")
    yield Measurement("link cut: question on the robot p99", p99(alone.taken_ms), "ms")
    yield Measurement("link cut: questions not answered", alone.unanswered, "")
    with both.still():
        both.wait("equal digests", lambda: not both.difference(), CATCH_UP_S)
    yield Measurement("link back: equal digests after", time.monotonic() - healed_s, "s")


def _probe(where: Machine, seconds: float) -> Probed:
    """Run a probe in a process of its own, there."""
    command = [sys.executable, "-m", "sceneq_tools.bench.link_probe", LOCAL, SCENE, str(seconds)]
    done = subprocess.run(where.command(*command), capture_output=True, text=True, check=False)
    if done.returncode:
        raise BrokenError(f"probe: {done.stderr.strip().splitlines()[-1:]}")
    found = Probed(**json.loads(done.stdout))
    if not found.taken_ms:
        raise BrokenError("no question was answered")
    return found
