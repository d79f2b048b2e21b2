"""The way of a keyframe through the graph, as it is heard on the bus."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue

from sceneq_nodes._client import Client
from sceneq_nodes._wire import from_bytes
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.topics import (
    FEATURE_DELTA,
    FRAME,
    LABEL_DELTA,
    MAP_DELTA,
    MASK,
    VIEW_DELTA,
    Topic,
)

STAGES = {
    FRAME: "ingest: frame",
    MASK: "segmentation: masks",
    MAP_DELTA: "mapping: map delta",
    VIEW_DELTA: "views: view delta",
    FEATURE_DELTA: "encoding: descriptors",
    LABEL_DELTA: "routing: labels",
}
"""What is heard of a keyframe, in the order in which it is made."""


@dataclass(frozen=True, slots=True)
class Heard:
    """A message: of which topic and keyframe, how large, and when on the clock of the listener."""

    topic: Topic
    frame_seq: int
    size: int
    at_s: float


@dataclass(slots=True)
class FrameTrace:
    """When each stage of one keyframe was first heard; ``at_s`` by topic, ``size`` in bytes."""

    frame_seq: int
    at_s: dict[Topic, float] = field(default_factory=dict)
    size: dict[Topic, int] = field(default_factory=dict)

    def is_whole(self) -> bool:
        """Tell whether every stage was heard."""
        return self.at_s.keys() == STAGES.keys()

    def rows(self) -> list[tuple[str, str, str, str]]:
        """Return frame, stage, milliseconds since the frame, and KiB, as text."""
        start_s = self.at_s[FRAME]
        return [
            (
                str(self.frame_seq),
                name,
                f"{1e3 * (self.at_s[topic] - start_s):.1f}" if topic in self.at_s else "-",
                f"{self.size[topic] / 1024:.1f}" if topic in self.size else "-",
            )
            for topic, name in STAGES.items()
        ]


class Tracer:
    """Follows keyframes from their frame on.

    Mask and map tell their keyframe by its seq. Views, descriptors and labels are of all that was
    seen so far: they count for every keyframe up to the one they name.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self.traces: dict[int, FrameTrace] = {}

    def take(self, heard: Heard) -> None:
        """Book a message on the keyframes it belongs to."""
        if heard.topic is FRAME and len(self.traces) < self._most:
            self.traces.setdefault(heard.frame_seq, FrameTrace(heard.frame_seq))
        exact = heard.topic in (FRAME, MASK, MAP_DELTA)
        for seq, trace in self.traces.items():
            if seq == heard.frame_seq or (seq < heard.frame_seq and not exact):
                trace.at_s.setdefault(heard.topic, heard.at_s)
                trace.size.setdefault(heard.topic, heard.size)

    def is_done(self) -> bool:
        """Tell whether enough keyframes were followed to their end."""
        whole = [trace.is_whole() for trace in self.traces.values()]
        return len(whole) == self._most and all(whole)


def trace_frames(
    client: Client, most: int, patience_s: float, clock: Callable[[], float] = time.monotonic
) -> list[FrameTrace]:
    """Return the traces of the next ``most`` keyframes, or of what came within ``patience_s``."""
    inbox: SimpleQueue[Heard] = SimpleQueue()
    for topic in STAGES:
        client.subscribe(topic.selector(), _into(inbox, topic, clock))
    tracer, deadline_s = Tracer(most), clock() + patience_s
    while not tracer.is_done() and (left_s := deadline_s - clock()) > 0:
        try:
            tracer.take(inbox.get(timeout=left_s))
        except Empty:
            break
    return list(tracer.traces.values())


def _into(
    inbox: "SimpleQueue[Heard]", topic: Topic, clock: Callable[[], float]
) -> Callable[[str, str, bytes], None]:
    def put(_: str, __: str, payload: bytes) -> None:
        at_s = clock()
        try:
            message = from_bytes(topic, payload)
        except DecodeError:
            return  # the nodes count these; a listener has nothing to follow in them
        seq = message.seq if topic in (FRAME, MASK) else message.frame_seq
        inbox.put(Heard(topic, seq, len(payload), at_s))

    return put
