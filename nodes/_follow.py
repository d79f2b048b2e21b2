"""The reader's side of a ``Delivery.STATE`` topic: deltas in order, gaps healed by a snapshot.

Every delta carries ``epoch`` (a new one with each start of the writer), ``seq`` (1, 2, 3, ...) and
``full`` (it holds the whole state). A reader subscribes first and asks for the snapshot second, so
that nothing falls between the two.
"""

import logging
import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from sceneq_nodes._bus import Bus, QueryError
from sceneq_nodes._wire import from_bytes
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.topics import Topic

log = logging.getLogger(__name__)

DEPTH = 64
RETRY_S = 1.0
TIMEOUT_S = 2.0


class Follower:
    """Calls ``apply`` with the messages of one writer such that no change is missed or repeated.

    A message with ``full`` replaces everything applied before; any other one follows on the last.

    In the node: ``follower.open()`` in ``open``, ``follower.offer(message)`` for each delta in
    ``step`` and ``follower.tick()`` when ``step`` is idle.
    """

    def __init__(
        self,
        bus: Bus,
        delta_topic: Topic,
        snapshot_topic: Topic,
        apply: Callable[[Any], None],
        *,
        clock: Callable[[], float] = time.monotonic,
        journal_topic: Topic | None = None,
        have: tuple[int, int] | None = None,
        **ids: str,
    ) -> None:
        """``journal_topic`` heals gaps without skipping what lies between; ``have`` are epoch and
        seq of the state at hand from an earlier run, (0, 0) = follow from the very beginning.
        """
        self.epoch: int | None = have[0] if have else None
        self.seq = have[1] if have else 0
        self.resyncs = 0
        self._bus = bus
        self._delta_topic = delta_topic
        self._snapshot_topic = snapshot_topic
        self._journal_topic = journal_topic
        self._apply = apply
        self._clock = clock
        self._ids: dict[str, Any] = ids
        self._behind = True
        self._pending: deque[Any] = deque(maxlen=DEPTH)
        self._next_ask = 0.0

    @property
    def synced(self) -> bool:
        """True while every delta seen so far is applied."""
        return not self._behind

    def open(self) -> None:
        """Subscribe, then ask for the snapshot; nobody needs to be there yet."""
        self._bus.subscribe(self._delta_topic, depth=DEPTH, **self._ids)
        self._catch_up()

    def offer(self, delta: Any) -> None:
        """Take the next delta: apply it, ignore it, or keep it until the gap is healed.

        Blocks for at most the snapshot's timeout, and only when the state is behind.
        """
        if self._accept(delta):
            self._replay()
            return
        if delta.epoch == self.epoch and delta.seq <= self.seq:
            return
        if self.synced:
            self._lost(delta)
        self._pending.append(delta)
        self._catch_up()

    def tick(self) -> None:
        """Ask again, rate limited, as long as the state is behind."""
        if self._behind:
            self._catch_up()

    def _accept(self, delta: Any) -> bool:
        """Apply ``delta`` if the state it builds on is the one at hand, or if it needs none."""
        follows = delta.epoch == self.epoch and delta.seq == self.seq + 1
        if not follows and not _starts(delta, self.epoch, self.seq):
            return False
        if self.epoch is not None and delta.epoch != self.epoch and self.synced:
            self._lost(delta)
        first = not follows and not delta.full
        self._apply(replace(delta, full=True) if first else delta)
        self.epoch, self.seq, self._behind = delta.epoch, delta.seq, False
        return True

    def _catch_up(self) -> None:
        """Fetch the snapshot and replay what arrived since; at most once per ``RETRY_S``."""
        if self._clock() < self._next_ask:
            return
        if self._read_journal():
            self._next_ask = self._clock() + RETRY_S
            self._replay()
            return
        snapshot = self._fetch(self._snapshot_topic)
        self._next_ask = self._clock() + RETRY_S
        if snapshot is not None:
            self._accept(replace(snapshot, full=True))
            self._replay()

    def _replay(self) -> None:
        """Apply the pending deltas that now follow; what is left means the state is behind."""
        waiting = sorted(self._pending, key=lambda delta: delta.seq)
        self._pending.clear()
        for delta in waiting:
            if delta.epoch == self.epoch and delta.seq > self.seq and not self._accept(delta):
                self._pending.append(delta)
        self._behind = bool(self._pending)

    def _read_journal(self) -> bool:
        """Apply what was missed, one by one; tell whether the writer still knew all of it."""
        if self._journal_topic is None or self.epoch is None:
            return False
        missed = self._fetch(self._journal_topic, epoch=str(self.epoch), after=str(self.seq))
        if missed is None or self.epoch not in (0, missed.epoch):
            return False
        for delta in missed.deltas:
            self._apply(delta)
        self.epoch, self.seq = missed.epoch, missed.seq
        return True

    def _fetch(self, topic: Topic, **parameters: str) -> Any:
        try:
            replies = self._bus.ask(topic, parameters=parameters, timeout_s=TIMEOUT_S, **self._ids)
            found = [from_bytes(topic, reply.payload) for reply in replies]
        except (QueryError, DecodeError) as error:
            self._bus.count(f"{topic.name}_failed")
            log.warning("%s: no answer: %s", topic.name, error)
            return None
        return max(found, key=lambda message: (message.epoch, message.seq), default=None)

    def _lost(self, delta: Any) -> None:
        self._behind = True
        self.resyncs += 1
        self._bus.count(f"{self._delta_topic.name}_resyncs")
        log.warning(
            "%s: at %s:%d got %d:%d, asking for the snapshot",
            *(self._delta_topic.name, self.epoch, self.seq, delta.epoch, delta.seq),
        )


def _starts(delta: Any, epoch: int | None, seq: int) -> bool:
    """Tell whether ``delta`` is news and stands alone: the first of its epoch, or a full one."""
    return bool((delta.full or delta.seq == 1) and (delta.epoch != epoch or delta.seq > seq))
