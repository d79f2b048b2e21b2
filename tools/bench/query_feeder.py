"""What a routing node follows, for the bench of queries: a finished map, at rest or at work.

    python -m sceneq_tools.bench.query_feeder ENDPOINT OPTIONS   # options as JSON

Makes the map of a recording, serves its snapshots, and prints ``Fed`` as JSON; ends with its input.
Asked for ``hz`` on ``FEED``, it publishes changes of so many keyframes a second from then on, those
of the last ones over and over; 0 = none.
"""

import json
import sys
import threading
from collections import deque
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from sceneq_nodes._bus import Bus, Context, Received, Reply, Request
from sceneq_nodes._counters import Counters
from sceneq_nodes._runtime import ZenohBus
from sceneq_schemas.topics import (
    FEATURE_DELTA,
    FEATURE_SNAPSHOT,
    MAP_DELTA,
    MAP_SNAPSHOT,
    QUERY_STATUS,
    VIEW_DELTA,
    VIEW_SNAPSHOT,
    Delivery,
    Topic,
)
from sceneq_tools.batch import Batch
from sceneq_tools.bench.measurement import Options
from sceneq_tools.bench.recording import open_plan, play
from sceneq_tools.errors import UserError

NODE = "bench"
FEED = Topic("bench_feed", "sceneq/@bench/feed", NODE, Delivery.QUERY, 0, 1024)
OF_A_KEYFRAME = {MAP_DELTA: 1, VIEW_DELTA: 1, FEATURE_DELTA: 2}
"""How many messages follow on a keyframe; a processor describes about 20 instances a second."""
KEPT = 30
"""Keyframes whose changes are told again."""


@dataclass(frozen=True, slots=True)
class Fed:
    """What a routing node of the graph needs, and how many instances it can answer with."""

    scene: str
    params: Mapping[str, Any]
    answerable: int


class LastChanges:
    """A node that keeps the last changes of map, views and descriptors."""

    Params: ClassVar[type] = object
    idle_s: ClassVar[float] = 1.0

    def __init__(self) -> None:
        self.heard: dict[Topic, deque[Received]] = {
            topic: deque(maxlen=KEPT * each) for topic, each in OF_A_KEYFRAME.items()
        }

    def open(self, bus: Bus) -> None:
        """Listen to all three."""
        for topic in self.heard:
            bus.subscribe(topic, depth=1, scene=bus.context.scene)

    def step(self, received: Received | None) -> None:
        """Keep a change."""
        if received is not None:
            self.heard[received.topic].append(received)

    def close(self) -> None:
        """Nothing to release."""


class Feeder:
    """Publishes the last changes again and again, as the next ones of the same writers."""

    def __init__(self, bus: Bus, changes: LastChanges) -> None:
        self._bus = bus
        self._heard = changes.heard
        self._seq = {topic: heard[-1].message.seq for topic, heard in self._heard.items()}
        self._hz = 0.0
        self._woken = threading.Event()
        threading.Thread(target=self._run, name="feeder", daemon=True).start()

    def set_rate(self, request: Request) -> Reply:
        """Publish the changes of ``hz`` keyframes a second from now on."""
        self._hz = float(request.parameters["hz"])
        self._woken.set()
        return Reply(b"{}", FEED.encoding)

    def tell_keyframe(self) -> None:
        """Publish what follows on one keyframe."""
        for topic, each in OF_A_KEYFRAME.items():
            for _ in range(each):
                self._tell_next(topic)

    def _tell_next(self, topic: Topic) -> None:
        heard = self._heard[topic]
        heard.rotate(-1)
        self._seq[topic] += 1
        message = replace(heard[-1].message, seq=self._seq[topic], full=False)
        self._bus.publish(topic, message, **heard[-1].ids)

    def _run(self) -> None:
        while True:
            self._woken.wait(1 / self._hz if self._hz else None)
            self._woken.clear()
            if self._hz:
                self.tell_keyframe()


def main() -> None:
    """Make the map, then serve and tell of it until standard input ends."""
    options, changes = options_from(sys.argv[2]), LastChanges()
    batch = Batch(open_plan(options), {NODE: changes})
    play(batch, options)
    bus = ZenohBus(Context(NODE, batch.scene, NODE, NODE), sys.argv[1], Counters())
    serve(bus, batch, changes)
    bus.announce(NODE)
    print(json.dumps(asdict(fed(batch))), flush=True)
    sys.stdin.read()
    bus.close()
    batch.close()


def serve(bus: Bus, batch: Batch, changes: LastChanges) -> None:
    """Answer for the snapshots of the map, its views and descriptors, and for the rate.

    Raises:
        UserError: the recording is too short for any descriptor.
    """
    if not all(changes.heard.values()):
        raise UserError("no instance of the recording was described", 2)
    for topic, delta in (
        (MAP_SNAPSHOT, MAP_DELTA),
        (VIEW_SNAPSHOT, VIEW_DELTA),
        (FEATURE_SNAPSHOT, FEATURE_DELTA),
    ):
        ids = {"scene": batch.scene, **changes.heard[delta][-1].ids}
        bus.serve(topic, _forward(batch, topic, ids), **ids)
    bus.serve(FEED, Feeder(bus, changes).set_rate)


def _forward(batch: Batch, topic: Topic, ids: Mapping[str, str]) -> Any:
    others = {name: value for name, value in ids.items() if name != "scene"}
    return lambda request: batch.get(topic, {}, **others)


def fed(batch: Batch) -> Fed:
    """Return what to start a routing node with."""
    reply = batch.get(QUERY_STATUS, {})
    answerable = json.loads(reply.payload)["answerable"] if reply else 0
    return Fed(batch.scene, batch.params_of("routing"), answerable)


def text_from(options: Options) -> str:
    """Return the options as one argument of a command."""
    plain = asdict(options)
    for name in ("source", "graph"):
        plain[name] = None if plain[name] is None else str(plain[name])
    return json.dumps(plain)


def options_from(text: str) -> Options:
    """Return the options in an argument."""
    plain = json.loads(text)
    for name in ("source", "graph"):
        plain[name] = None if plain[name] is None else Path(plain[name])
    return Options(**plain)


if __name__ == "__main__":
    main()
