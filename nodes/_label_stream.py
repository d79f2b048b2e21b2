"""The stream of names: publishes what instances are called, answers for the whole.

Written by the node's own thread; the snapshot is read and reasoners' names come from any other.
"""

import time
from dataclasses import replace
from threading import Lock

import numpy as np

from sceneq_core.routing.answer import Naming
from sceneq_core.routing.label_board import InstanceLabel, LabelBoard
from sceneq_core.routing.namer import Namer
from sceneq_core.routing.scene import SceneSnapshot
from sceneq_nodes._bus import Bus, Reply, Request
from sceneq_nodes._epoch import new_epoch
from sceneq_nodes._pages import paged
from sceneq_nodes._wire import to_bytes
from sceneq_schemas.label import InstanceLabel as InstanceLabelMessage
from sceneq_schemas.label import LabelDelta
from sceneq_schemas.topics import LABEL_DELTA, LABEL_SNAPSHOT

PERIOD_S = 0.5
"""Changes are gathered for this long: names are for displays and logs, not for control."""


class LabelStream:
    """Names the instances of one scene in the vectors of one encoder at a time."""

    def __init__(self, bus: Bus, scene: str, period_s: float = PERIOD_S) -> None:
        self._bus = bus
        self._scene = scene
        self._period_s = period_s
        self._next_s = 0.0
        self._seen: SceneSnapshot | None = None
        self._namer: Namer | None = None
        self._news = False
        self._lock = Lock()
        self._last = LabelDelta(
            epoch=new_epoch(),
            seq=0,
            full=True,
            frame_seq=-1,
            stamp_ns=0,
            model_id="",
            label_set="",
            map_epoch=0,
            labels=(),
            removed=np.zeros(0, np.int32),
        )
        bus.serve(LABEL_SNAPSHOT, paged(self._answer), scene=scene)

    def tell(self, naming: Naming) -> None:
        """Take over what a reasoner calls an instance."""
        with self._lock:
            if self._namer is not None:
                self._board.tell(naming)
                self._news = True

    def tick(self, model: str, namer: Namer, snapshot: SceneSnapshot) -> None:
        """Publish what is called otherwise since the last time, if it is time."""
        if (snapshot is self._seen and not self._news) or time.monotonic() < self._next_s:
            return
        self._next_s = time.monotonic() + self._period_s
        with self._lock:
            delta = self._next(model, namer, snapshot)
        if delta is not None:
            self._bus.publish(LABEL_DELTA, delta, scene=self._scene)

    def _next(self, model: str, namer: Namer, snapshot: SceneSnapshot) -> LabelDelta | None:
        """Another encoder or another map begins anew: nothing of the old one holds there."""
        self._seen, self._news = snapshot, False
        revision = snapshot.revision
        anew = namer is not self._namer or revision.epoch != self._last.map_epoch
        if anew:
            self._namer, self._board = namer, LabelBoard(namer)
        changes = self._board.update(snapshot)
        if not changes and not (anew and self._last.seq):
            return None
        self._last = LabelDelta(
            epoch=self._last.epoch,
            seq=self._last.seq + 1,
            full=anew,
            frame_seq=revision.frame_seq,
            stamp_ns=revision.stamp_ns,
            model_id=model,
            label_set=namer.labeller.label_set.name,
            map_epoch=revision.epoch,
            labels=tuple(map(_message, changes.labels)),
            removed=np.array(changes.removed, np.int32),
        )
        return self._last

    def _answer(self, request: Request) -> Reply:
        with self._lock:
            named = self._board.all() if self._namer is not None else ()
            whole = _whole(self._last, tuple(map(_message, named)))
        return Reply(to_bytes(LABEL_SNAPSHOT, whole), LABEL_SNAPSHOT.encoding)


def _whole(last: LabelDelta, labels: tuple[InstanceLabelMessage, ...]) -> LabelDelta:
    return replace(last, full=True, labels=labels, removed=np.zeros(0, np.int32))


def _message(label: InstanceLabel) -> InstanceLabelMessage:
    return InstanceLabelMessage(
        label.instance_id, label.name, label.p, label.accepted, label.source
    )
