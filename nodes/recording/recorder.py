"""Writes a run of the graph into one MCAP file, which a source can play again.

Reads   keyframes, poses and corrections of one robot; the map's deltas; masks if wanted.
Asks    the front door for its last answers, twice a second.
Writes  nothing on the bus; the file grows by a chunk with every keyframe, and at least every
        ``flush_s``: what a kill -9 leaves can be read. A recorder that starts again goes on in
        ``OUT.2.mcap``.
Rate    everything that comes; a keyframe that is sent again is written once (``frames_repeated``).
Bad     a keyframe that does not decode counts as ``frames_bad``; one that was sent but never came
        as ``frames_missed``; when the disk takes no more, or ``max_mb`` are written, the recording
        ends, says so (``state``), and what comes counts as ``messages_unrecorded``.
"""

import json
import logging
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from sceneq_nodes._bus import Bus, Context, QueryError, Received
from sceneq_nodes._wire import json_bytes, to_bytes
from sceneq_nodes.recording import forms
from sceneq_nodes.recording.forms import Said
from sceneq_nodes.recording.mcap_writer import McapWriter
from sceneq_schemas import topics
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.frame import Frame, Pose

log = logging.getLogger(__name__)

DEPTHS = {topics.FRAME: 32, topics.POSE: 256, topics.POSE_CORRECTION: 32}
STATE_DEPTH = 64
PACKED = {
    topics.POSE_CORRECTION: forms.CORRECTION,
    topics.MASK: forms.MASKS,
    topics.MAP_DELTA: forms.MAP,
}
ANSWERS_S = 0.5
ANSWERS = 3
"""So many whole answers the front door remembers."""
TIMEOUT_S = 1.0
MIB = 1024 * 1024
PARTS = 1000


@dataclass(frozen=True, slots=True)
class RecorderParams:
    """``path`` of the file; ``masks`` and ``map`` as well, or frames and answers only.

    ``max_mb`` 0 = as long as the disk takes it. ``flush_s``: so much of the poses and answers may
    be lost at a kill -9.
    """

    path: str
    masks: bool = False
    map: bool = True
    max_mb: int = 0
    flush_s: float = 1.0

    def __post_init__(self) -> None:
        if self.max_mb < 0:
            raise ValueError(f"max_mb: expected 0 or more, got {self.max_mb}")
        if not self.flush_s > 0:
            raise ValueError(f"flush_s: expected more than 0, got {self.flush_s}")


class Recorder:
    """Keeps what one robot shows and what becomes of it."""

    Params: ClassVar[type] = RecorderParams
    idle_s: ClassVar[float] = 0.2

    def __init__(
        self,
        params: RecorderParams,
        context: Context,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._params = params
        self._context = context
        self._clock = clock
        self._file: McapWriter | None = None
        self._seen: set[tuple[int, int]] = set()
        self._seqs: set[int] = set()
        self._answered: set[str] = set()
        self._stamp_ns = self._keyframes = self._poses = 0

    def open(self, bus: Bus) -> None:
        """Begin the file, then listen; raise ``ValueError`` when it cannot be written."""
        self._bus, context = bus, self._context
        forms.store()
        path = free_part(Path(self._params.path))
        self._file = McapWriter(path)
        log.info("recording into %s", path)
        robot = {"robot": context.robot}
        bus.subscribe(topics.FRAME, depth=DEPTHS[topics.FRAME], sensor=context.sensor, **robot)
        for topic in (topics.POSE, topics.POSE_CORRECTION):
            bus.subscribe(topic, depth=DEPTHS[topic], **robot)
        for topic, wanted in ((topics.MASK, self._params.masks), (topics.MAP_DELTA, True)):
            if wanted and (topic is not topics.MAP_DELTA or self._params.map):
                bus.subscribe(topic, depth=STATE_DEPTH, scene=context.scene)
        self._flush_due_s = self._answers_due_s = self._clock()
        bus.report(state="recording", file=str(path))

    def step(self, received: Received | None) -> None:
        """Write a message; now and then answers, and what is still in memory."""
        if received is not None:
            self._take(received)
        now_s = self._clock()
        if now_s >= self._answers_due_s:
            self._write(self._answers())
            self._answers_due_s = self._clock() + ANSWERS_S
        if now_s >= self._flush_due_s:
            self._flush()

    def close(self) -> None:
        """End the file with its index."""
        if self._file is not None:
            self._end("stopped")

    def _take(self, received: Received) -> None:
        message, topic = received.message, received.topic
        if topic is topics.FRAME:
            self._take_keyframe(message)
        elif topic is topics.POSE:
            self._take_pose(message)
        else:
            self._stamp_ns = getattr(message, "stamp_ns", 0) or self._stamp_ns
            data = to_bytes(topic, message)
            schema = str(type(message).SCHEMA)
            self._write([forms.packed_said(PACKED[topic], schema, data, self._stamp_ns)])

    def _take_keyframe(self, frame: Frame) -> None:
        name = frame.seq, frame.stamp_ns
        if name in self._seen:
            self._bus.count("frames_repeated")
            return
        if self._seqs and frame.after not in (-1, frame.seq) and frame.after not in self._seqs:
            self._bus.count("frames_missed")
            log.warning("keyframe %d is missing before keyframe %d", frame.after, frame.seq)
        try:
            said = list(forms.keyframe_said(frame))
        except DecodeError as error:
            self._bus.count("frames_bad")
            log.warning("keyframe %d not recorded: %s", frame.seq, error)
            return
        self._seen.add(name)
        self._seqs.add(frame.seq)
        self._stamp_ns = frame.stamp_ns
        self._keyframes += 1
        self._write(said)
        self._flush()

    def _take_pose(self, pose: Pose) -> None:
        self._poses += 1
        self._write([forms.pose_said(pose)])

    def _answers(self) -> list[Said]:
        """Return the answers given since they were last asked for, the oldest first."""
        asked = {"k": str(ANSWERS)}
        try:
            replies = self._bus.ask(
                topics.QUERY_LAST, parameters=asked, timeout_s=TIMEOUT_S, scene=self._context.scene
            )
        except QueryError as error:
            log.info("answers: %s", error)
            return []
        answers = [answer for reply in replies for answer in self._read(reply.payload)]
        new = [a for a in reversed(answers) if str(a.get("query_id")) not in self._answered]
        self._answered.update(str(answer.get("query_id")) for answer in new)
        return [forms.answer_said(json_bytes(answer).decode(), self._stamp_ns) for answer in new]

    def _read(self, payload: bytes) -> list[dict[str, Any]]:
        try:
            answers = json.loads(payload)["answers"]
            return [answer for answer in answers if isinstance(answer, dict)]
        except (ValueError, TypeError, KeyError, RecursionError):
            self._bus.count("answers_bad")
            return []

    def _write(self, said: Iterable[Said]) -> None:
        for one in said:
            if self._file is None:
                self._bus.count("messages_unrecorded")
                continue
            try:
                self._file.write(one)
            except OSError as error:
                self._fail(error)

    def _flush(self) -> None:
        self._flush_due_s = self._clock() + self._params.flush_s
        if self._file is None:
            return
        try:
            self._file.flush()
        except OSError as error:
            self._fail(error)
            return
        size = self._file.size
        self._bus.report(keyframes=self._keyframes, poses=self._poses, mb=round(size / MIB, 1))
        if self._params.max_mb and size >= self._params.max_mb * MIB:
            log.warning("the recording has %d MB and ends", self._params.max_mb)
            self._end("full")

    def _fail(self, error: OSError) -> None:
        log.error("the recording ends: %s", error.strerror or error)
        self._end(f"failed: {error.strerror or error}")

    def _end(self, state: str) -> None:
        file, self._file = self._file, None
        self._bus.report(state=state)
        try:
            if file is not None:
                file.close()
        except OSError as error:
            log.error("index and summary could not be written: %s", error.strerror or error)


def free_part(path: Path) -> Path:
    """Return ``path``, or the first of its numbered parts that does not exist.

    Raises:
        ValueError: there are too many.
    """
    parts = (path.with_suffix(f".{n}{path.suffix}") for n in range(2, PARTS))
    for candidate in (path, *parts):
        if not candidate.exists():
            return candidate
    raise ValueError(f"{path}: it and {PARTS - 2} more parts of it are there already")
