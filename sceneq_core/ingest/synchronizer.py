"""Which messages of several streams belong together: those taken at nearly the same time."""

from collections import deque
from dataclasses import dataclass
from typing import Generic, TypeVar

from sceneq_core.checks import need_at_least

Item = TypeVar("Item")
NS_PER_S = 1e9


@dataclass(frozen=True, slots=True)
class SyncParams:
    """Stamps up to ``tolerance_s`` apart belong together; ``capacity`` items of a stream wait."""

    tolerance_s: float = 0.02
    capacity: int = 16

    def __post_init__(self) -> None:
        need_at_least(self, 0, "tolerance_s")
        need_at_least(self, 1, "capacity")


@dataclass(frozen=True, slots=True)
class Unmatched:
    """A message that goes alone; ``apart_s``: to the nearest of the other stream, if any came."""

    stream: str
    stamp_ns: int
    apart_s: float | None


@dataclass(frozen=True, slots=True)
class Synced(Generic[Item]):
    """One item of each stream, in the order the streams were named, at the stamp of the first."""

    stamp_ns: int
    items: tuple[Item, ...]


class Synchronizer(Generic[Item]):
    """Joins each item of the first stream with the nearest of every other one.

    An item is joined when nothing nearer can come any more, because each other stream has passed
    its stamp; so the result does not depend on which message arrived first. Stamps within a stream
    grow; one that does not is refused. Each item is used once.
    """

    def __init__(self, params: SyncParams, *streams: str) -> None:
        if len(streams) < 2:
            raise ValueError(f"streams: expected two or more, got {streams}")
        self._tolerance_ns = round(params.tolerance_s * NS_PER_S)
        self._capacity = params.capacity
        self._first, *self._others = streams
        self._waiting: dict[str, deque[tuple[int, Item]]] = {name: deque() for name in streams}
        self._last_ns: dict[str, int] = {}

    def add(self, stream: str, stamp_ns: int, item: Item) -> list[Synced[Item] | Unmatched]:
        """Take the next item of ``stream``; return what is settled now, in order.

        Raises:
            ValueError: the stamp does not grow; nothing has changed then.
        """
        last_ns = self._last_ns.get(stream)
        if last_ns is not None and stamp_ns <= last_ns:
            back_s = (last_ns - stamp_ns) / NS_PER_S
            raise ValueError(f"{stream}: stamp goes back by {back_s:.3f} s")
        self._last_ns[stream] = stamp_ns
        waiting = self._waiting[stream]
        waiting.append((stamp_ns, item))
        settled: list[Synced[Item] | Unmatched] = []
        if len(waiting) > self._capacity:
            # The other streams do not come: the oldest has waited long enough.
            stamp_ns, _ = waiting.popleft()
            settled.append(Unmatched(stream, stamp_ns, self._apart_s(stream, stamp_ns)))
        return settled + self._settle()

    def flush(self) -> list[Synced[Item] | Unmatched]:
        """Join what waits and has a partner, as when nothing more comes; what has none waits on."""
        settled: list[Synced[Item] | Unmatched] = []
        first = self._waiting[self._first]
        while first and all(self._has_near(stream, first[0][0]) for stream in self._others):
            settled += self._join(*first.popleft())
        return settled

    def clear(self) -> int:
        """Forget everything, stamps too; return how many items waited."""
        count = sum(map(len, self._waiting.values()))
        for waiting in self._waiting.values():
            waiting.clear()
        self._last_ns.clear()
        return count

    def _settle(self) -> list[Synced[Item] | Unmatched]:
        settled: list[Synced[Item] | Unmatched] = []
        first = self._waiting[self._first]
        while first and all(self._is_past(stream, first[0][0]) for stream in self._others):
            settled += self._join(*first.popleft())
        return settled

    def _is_past(self, stream: str, stamp_ns: int) -> bool:
        """Tell whether nothing nearer to the stamp can come on ``stream``, or nothing near."""
        waiting = self._waiting[stream]
        if waiting and waiting[-1][0] >= stamp_ns:
            return True
        return self._last_ns.get(stream, 0) > stamp_ns + self._tolerance_ns

    def _has_near(self, stream: str, stamp_ns: int) -> bool:
        return any(abs(ns - stamp_ns) <= self._tolerance_ns for ns, _ in self._waiting[stream])

    def _join(self, stamp_ns: int, item: Item) -> list[Synced[Item] | Unmatched]:
        """Take the nearest of each other stream; what is older than it goes alone."""
        settled: list[Synced[Item] | Unmatched] = []
        found = [self._nearest(stream, stamp_ns) for stream in self._others]
        if any(at is None for at in found):
            return [Unmatched(self._first, stamp_ns, self._apart_s(self._first, stamp_ns))]
        items = [item]
        for stream, at in zip(self._others, found, strict=True):
            waiting = self._waiting[stream]
            for _ in range(at or 0):
                old_ns, _ = waiting.popleft()
                settled.append(Unmatched(stream, old_ns, abs(stamp_ns - old_ns) / NS_PER_S))
            items.append(waiting.popleft()[1])
        return [*settled, Synced(stamp_ns, tuple(items))]

    def _nearest(self, stream: str, stamp_ns: int) -> int | None:
        """Return the place of the nearest item within the tolerance, the earlier of two equal."""
        apart = [abs(other_ns - stamp_ns) for other_ns, _ in self._waiting[stream]]
        if not apart or min(apart) > self._tolerance_ns:
            return None
        return apart.index(min(apart))

    def _apart_s(self, stream: str, stamp_ns: int) -> float | None:
        others = self._others if stream == self._first else [self._first]
        near = [
            min((abs(ns - stamp_ns) for ns, _ in self._waiting[other]), default=None)
            or self._since_last(other, stamp_ns)
            for other in others
        ]
        known = [apart for apart in near if apart is not None]
        return max(known) / NS_PER_S if known else None

    def _since_last(self, stream: str, stamp_ns: int) -> int | None:
        last_ns = self._last_ns.get(stream)
        return None if last_ns is None else abs(last_ns - stamp_ns)
