"""What is told without being asked, as an iterator."""

import queue
from collections.abc import Callable, Iterator
from typing import Generic, TypeVar

T = TypeVar("T")
MAX_WAITING = 1000
_END = object()


class Subscription(Generic[T]):
    """Yields what happens until it is closed; use it in a ``with`` block.

    A reader that is too slow loses the oldest: ``lost`` counts how many.
    """

    def __init__(self) -> None:
        self._waiting: queue.Queue[object] = queue.Queue(MAX_WAITING)
        self._ends: list[Callable[[], None]] = []
        self._closed = False
        self.lost = 0

    def on_close(self, end: Callable[[], None]) -> None:
        """Call ``end`` when nobody wants to be told any more."""
        self._ends.append(end)

    def put(self, event: T) -> None:
        """Tell ``event``; never waits."""
        while not self._closed:
            try:
                self._waiting.put_nowait(event)
                break
            except queue.Full:
                self._drop_oldest()

    def get(self, timeout_s: float | None = None) -> T | None:
        """Return the next event; ``None`` when there is none in time or no more will come."""
        try:
            event = self._waiting.get(timeout=timeout_s)
        except queue.Empty:
            return None
        if event is _END:
            self._waiting.put(_END)  # for whoever else waits
            return None
        return event  # type: ignore[return-value]

    @property
    def closed(self) -> bool:
        """Whether nothing more will be told."""
        return self._closed

    def __iter__(self) -> Iterator[T]:
        while (event := self.get()) is not None:
            yield event

    def __enter__(self) -> "Subscription[T]":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Stop listening; iteration ends after what was told already."""
        if self._closed:
            return
        self._closed = True
        for end in self._ends:
            end()
        if self._waiting.full():
            self._drop_oldest()
        self._waiting.put(_END)

    def _drop_oldest(self) -> None:
        try:
            self._waiting.get_nowait()
        except queue.Empty:
            return
        self.lost += 1
