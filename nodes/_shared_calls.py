"""The same question is asked once: while it is under way and, if it went well, afterwards."""

import threading
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import Future


class SharedCalls:
    """Texts by the key of what was asked; the last ``capacity`` good ones are remembered."""

    def __init__(self, capacity: int) -> None:
        self._capacity = capacity
        self._lock = threading.Lock()
        self._under_way: dict[bytes, Future[str]] = {}
        self._known: OrderedDict[bytes, str] = OrderedDict()

    def start(
        self, key: bytes, call: Callable[[], "Future[str]"], good: Callable[[str], bool]
    ) -> tuple["Future[str]", bool]:
        """Return the call with this key, and whether it is a new one, started by ``call``.

        Its text is remembered when it is ``good``.
        """
        with self._lock:
            if key in self._known:
                self._known.move_to_end(key)
                return _done(self._known[key]), False
            if key in self._under_way:
                return self._under_way[key], False
            future = self._under_way[key] = call()
        future.add_done_callback(lambda ended: self._end(key, ended, good))
        return future, True

    def _end(self, key: bytes, ended: "Future[str]", good: Callable[[str], bool]) -> None:
        text = None if ended.exception() else ended.result()
        keep = text is not None and good(text)
        with self._lock:
            self._under_way.pop(key, None)
            if keep and text is not None:
                self._known[key] = text
            while len(self._known) > self._capacity:
                self._known.popitem(last=False)


def _done(text: str) -> "Future[str]":
    future: Future[str] = Future()
    future.set_result(text)
    return future
