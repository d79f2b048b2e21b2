"""The same frames over and over: what a keyframe costs and what mapping holds in a known room."""

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from typing import IO, Any, ClassVar

from sceneq_nodes._bus import Bus, Context, Received
from sceneq_nodes._wire import to_bytes
from sceneq_schemas.frame import Frame
from sceneq_schemas.mask import Masks
from sceneq_schemas.topics import FRAME, MASK
from sceneq_tools.batch import INGEST, Batch
from sceneq_tools.bench.lapping import HEADER, MAPPING
from sceneq_tools.bench.measurement import Measurement, Options, median
from sceneq_tools.bench.recording import first_frames, open_plan, play, replace_params
from sceneq_tools.errors import UserError
from sceneq_tools.graph_plan import Plan
from sceneq_tools.progress import progress

LAPS = 10
EARLY, LATE = 100, 500
"""Keyframes that are compared, each with those of a lap from it on: so both saw the same."""
KEPT = "kept"
AT_ONCE = {"rate_hz": 1e6, "wait_for": ()}
"""What makes ingest wait for nobody."""


class Kept:
    """A node that keeps keyframes and their masks."""

    Params: ClassVar[type] = object
    idle_s: ClassVar[float] = 1.0

    def __init__(self) -> None:
        self.frames: dict[int, Frame] = {}
        self.masks: dict[int, Masks] = {}

    def open(self, bus: Bus) -> None:
        """Listen to both halves of keyframes."""
        context = bus.context
        bus.subscribe(FRAME, depth=1, robot=context.robot, sensor=context.sensor)
        bus.subscribe(MASK, depth=1, scene=context.scene)

    def step(self, received: Received | None) -> None:
        """Keep a message."""
        if received is not None:
            half: dict[int, Any] = self.frames if received.topic is FRAME else self.masks
            half[received.message.seq] = received.message

    def close(self) -> None:
        """Nothing to release."""


def laps(options: Options) -> Iterator[Measurement]:
    """Map the recording again and again, as if the camera went on along the same path."""
    with first_frames(options) as shortened:
        plan = open_plan(shortened)
        kept = keyframes_of(plan, shortened)
    count = len(kept.masks)
    if not count:
        raise UserError("no keyframes in the recording", 2)
    wanted = max(LAPS * count, LATE + count)
    with mapping_process(plan) as process:
        taken_ms, held_mib = map_laps(process, kept, wanted, options.quiet)
    early_ms, late_ms = (median(taken_ms[k : k + count]) for k in (EARLY, LATE))
    beside, series = f"keyframe {EARLY}", tuple(taken_ms)
    yield Measurement(f"mapping, keyframe {LATE}", late_ms, "ms", beside, early_ms, series)
    ends = held_mib[count - 1 :: count]
    name = f"memory of mapping, {len(ends)} laps"
    yield Measurement(name, ends[-1], "MiB", "one lap", ends[0], tuple(held_mib))


def keyframes_of(plan: Plan, options: Options) -> Kept:
    """Return what ingest and segmentation make of the recording."""
    kinds = {INGEST: AT_ONCE, "segmentation": {}}
    nodes = tuple(
        replace_params(node, kinds[node.node_kind])
        for node in plan.nodes
        if node.node_kind in kinds
    )
    kept = Kept()
    batch = Batch(replace(plan, nodes=nodes), {KEPT: kept})
    try:
        play(batch, options)
    finally:
        batch.close()
    return kept


@contextmanager
def mapping_process(plan: Plan) -> "Iterator[subprocess.Popen[bytes]]":
    """Run the mapping node of ``plan`` in a process of its own until the end of the block."""
    mapping = next(node for node in plan.nodes if node.node_kind == MAPPING)
    context = Context(MAPPING, plan.scene, plan.robot, plan.sensor)
    said = json.dumps({"context": asdict(context), "params": mapping.params})
    command = [sys.executable, "-m", "sceneq_tools.bench.lapping", said]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        yield process
        assert process.stdin is not None
        process.stdin.close()


def map_laps(
    process: "subprocess.Popen[bytes]", kept: Kept, wanted: int, quiet: bool
) -> tuple[list[float], list[float]]:
    """Send ``wanted`` keyframes; return what each took, ms, and what is held after it, MiB."""
    assert process.stdin is not None
    assert process.stdout is not None
    taken_ms, held_mib = [], []
    with progress("keyframes", wanted, quiet=quiet) as advance:
        for frame, masks in on_and_on(kept, wanted):
            send(process.stdin, to_bytes(FRAME, frame), to_bytes(MASK, masks))
            line = process.stdout.readline().split()
            if not line:
                raise ConnectionError(f"mapping ended with exit code {process.wait()}")
            taken_ms.append(float(line[0]))
            held_mib.append(float(line[1]))
            advance()
    return taken_ms, held_mib


def on_and_on(kept: Kept, wanted: int) -> Iterator[tuple[Frame, Masks]]:
    """Yield ``wanted`` keyframes, lap after lap, each lap later than the one before."""
    seqs = sorted(kept.masks)
    stamps_ns = [kept.frames[seq].stamp_ns for seq in seqs]
    lap_seq = seqs[-1] - seqs[0] + 1
    between_ns = (stamps_ns[-1] - stamps_ns[0]) // max(len(seqs) - 1, 1)
    lap_ns = stamps_ns[-1] - stamps_ns[0] + max(between_ns, 1)
    for number in range(wanted):
        lap, row = divmod(number, len(seqs))
        seq, stamp_ns = seqs[row] + lap * lap_seq, stamps_ns[row] + lap * lap_ns
        yield (
            replace(kept.frames[seqs[row]], seq=seq, stamp_ns=stamp_ns),
            replace(kept.masks[seqs[row]], seq=seq, stamp_ns=stamp_ns),
        )


def send(stream: IO[bytes], *parts: bytes) -> None:
    """Send the two halves of a keyframe."""
    stream.write(HEADER.pack(*(len(part) for part in parts)))
    for part in parts:
        stream.write(part)
    stream.flush()
