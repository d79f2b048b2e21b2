"""The reader's side of a ``Delivery.STATE`` topic: deltas in order, gaps healed by asking.

Every delta carries ``epoch`` (a new one with each start of the writer), ``seq`` (1, 2, 3, ...) and
``full`` (it holds the whole state). A reader subscribes first and asks for the rest second, so
that nothing falls between the two: for what changed since it last knew, else for the whole.
"""

import logging
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from sceneq_nodes._bus import Bus, QueryError
from sceneq_nodes._fetch import Fetch
from sceneq_nodes._recent_deltas import FORGOTTEN
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.map import MapDeltas
from sceneq_schemas.topics import Topic

log = logging.getLogger(__name__)

DEPTH = 64
RETRY_S = 1.0
TURN_S = 0.5
"""How long pages are asked for before the node does something else."""
QUIET_S = 3.0
"""After so long without a delta: was there none, or was the last one lost with the link?"""
BITS = 8


@dataclass(frozen=True, slots=True)
class Pull:
    """For a thin link: ask every ``every_s`` seconds for what changed, with pages of at most
    ``mbit_s`` Mbit/s, instead of hearing every change.
    """

    every_s: float = 2.0
    mbit_s: float = 4.0

    def __post_init__(self) -> None:
        for name in ("every_s", "mbit_s"):
            if not 0 < getattr(self, name) < float("inf"):
                raise ValueError(f"{name}: expected more than 0, got {getattr(self, name)}")


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
        merged: bool = True,
        pull: Pull | None = None,
        have: tuple[int, int] | None = None,
        **ids: str,
    ) -> None:
        """``journal_topic`` heals gaps without the whole, and without ``merged`` change by change:
        then the whole is asked for only when the writer says that it has forgotten them.
        ``have`` are epoch and seq of the state at hand from an earlier run, (0, 0) = follow from
        the very beginning.
        """
        self.epoch: int | None = have[0] if have else None
        self.seq = have[1] if have else 0
        self.resyncs = 0
        self._bus = bus
        self._delta_topic = delta_topic
        self._snapshot_topic = snapshot_topic
        self._journal_topic = journal_topic
        self._merged = merged
        self._pull = pull
        self._apply = apply
        self._clock = clock
        self._ids: dict[str, Any] = ids
        self._behind = True
        self._pending: deque[Any] = deque(maxlen=DEPTH)
        self._next_ask = 0.0
        self._heard_s = clock()
        self._fetch: Fetch | None = None
        self._asked: tuple[int | None, int] | None = None
        self._is_forgotten = False

    @property
    def at(self) -> str:
        """What is applied, ``epoch:seq``, as its writer reports it."""
        return f"{self.epoch}:{self.seq}"

    @property
    def synced(self) -> bool:
        """True while every delta seen so far is applied."""
        return not self._behind

    def open(self) -> None:
        """Subscribe, then ask for the rest; nobody needs to be there yet."""
        if self._pull is None:
            self._bus.subscribe(self._delta_topic, depth=DEPTH, **self._ids)
        self._catch_up()

    def offer(self, delta: Any) -> None:
        """Take the next delta: apply it, ignore it, or keep it until the gap is healed.

        Blocks for little more than ``TURN_S`` or one page's timeout, and only when behind.
        """
        self._heard_s = self._clock()
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
        """Ask again, rate limited, as long as the state is behind, or when it may be."""
        if self._behind or self._pull is not None or self._is_quiet():
            self._catch_up()

    def _is_quiet(self) -> bool:
        """Tell whether it is time to look for a last delta that never came."""
        known = self._journal_topic is not None and self.epoch is not None
        waited = self._clock() - self._heard_s >= QUIET_S
        return known and (waited or self._fetch is not None)

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
        """Ask for what changed, else for the whole; replay what arrived since."""
        if self._clock() < self._next_ask:
            return
        is_healed = self._ask_changes()
        if is_healed is False and self._may_skip():
            is_healed = self._ask_whole()
        if is_healed is None:
            return  # more pages to come
        self._heard_s = self._clock()
        self._next_ask = self._heard_s + (self._pull.every_s if self._pull else RETRY_S)
        if is_healed:
            self._replay()
        elif self._pull is not None:
            self._behind = True

    def _may_skip(self) -> bool:
        """Tell whether the whole will do; a writer on its way back may still know every change."""
        return self._merged or self.epoch is None or self._is_forgotten

    def _ask_changes(self) -> bool | None:
        """Apply what was missed; tell whether the writer still knew all of it, None = not yet."""
        if self._journal_topic is None or self.epoch is None:
            return False
        if self._fetch is not None and self._asked is None:
            return False  # the whole is on its way
        begun = self._asked if self._fetch is not None else (self.epoch, self.seq)
        self._is_forgotten = False
        where = {"epoch": str(self.epoch), "after": str(self.seq)}
        if self._merged:
            where["merged"] = "1"
        missed = self._fetched(self._journal_topic, where, begun)
        if self._fetch is not None:
            return None
        if missed is None:
            return False
        if self.epoch not in (0, missed.epoch):
            self._is_forgotten = True
            return False
        if begun != (self.epoch, self.seq):
            return True  # a whole came meanwhile
        for delta in missed.deltas if isinstance(missed, MapDeltas) else (missed,):
            if delta.seq > self.seq:
                self._apply(delta)
        self.epoch, self.seq = missed.epoch, max(self.seq, missed.seq)
        return True

    def _ask_whole(self) -> bool | None:
        snapshot = self._fetched(self._snapshot_topic, {}, None)
        if self._fetch is not None:
            return None
        if snapshot is not None:
            self._accept(replace(snapshot, full=True))
        return snapshot is not None

    def _fetched(
        self, topic: Topic, parameters: dict[str, str], asked: tuple[int | None, int] | None
    ) -> Any:
        """Return what the topic holds, or ``None`` while pages are missing, or when nobody says."""
        if self._fetch is None:
            self._fetch = Fetch(self._bus, topic, parameters, **self._ids)
            self._asked = asked
        fetch, until_s = self._fetch, self._clock() + TURN_S
        try:
            while not fetch.done and self._clock() <= until_s:
                self._next_page(fetch)
        except (QueryError, DecodeError) as error:
            self._fetch = None
            is_known = isinstance(error, QueryError) and error.code == FORGOTTEN
            self._is_forgotten = is_known or isinstance(error, DecodeError)
            if not is_known:
                self._bus.count(f"{topic.name}_failed")
                log.warning("%s: no answer: %s", topic.name, error)
            return None
        if fetch.done:
            self._fetch = None
        return fetch.message

    def _next_page(self, fetch: Fetch) -> None:
        """Fetch a page; over a thin link wait as long as it would take at the agreed rate."""
        before = fetch.received
        fetch.step()
        if self._pull is not None:
            bits = BITS * (fetch.received - before)
            time.sleep(min(TURN_S, bits / (1e6 * self._pull.mbit_s)))

    def _replay(self) -> None:
        """Apply the pending deltas that now follow; what is left means the state is behind."""
        waiting = sorted(self._pending, key=lambda delta: delta.seq)
        self._pending.clear()
        for delta in waiting:
            if delta.epoch == self.epoch and delta.seq > self.seq and not self._accept(delta):
                self._pending.append(delta)
        self._behind = bool(self._pending)

    def _lost(self, delta: Any) -> None:
        self._behind = True
        self.resyncs += 1
        self._bus.count(f"{self._delta_topic.name}_resyncs")
        log.warning(
            "%s: at %s:%d got %d:%d, asking for what is missing",
            *(self._delta_topic.name, self.epoch, self.seq, delta.epoch, delta.seq),
        )


def _starts(delta: Any, epoch: int | None, seq: int) -> bool:
    """Tell whether ``delta`` is news and stands alone: the first of its epoch, or a full one."""
    return bool((delta.full or delta.seq == 1) and (delta.epoch != epoch or delta.seq > seq))
