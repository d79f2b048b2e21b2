"""What a node counts and reports about itself; every thread may write."""

import threading
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

Value = float | int | str


class Counters:
    """Messages per topic (in, out, dropped, undecodable), named counters and current values."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._topics: dict[str, Counter[str]] = {}
        self._last: dict[str, float] = {}
        self._named: Counter[str] = Counter()
        self._values: dict[str, Value] = {}

    def topic(self, name: str, event: str) -> int:
        """Count ``in``, ``out``, ``dropped`` or ``undecodable`` for a topic; return the total."""
        with self._lock:
            counter = self._topics.setdefault(name, Counter())
            counter[event] += 1
            if event in ("in", "out"):
                self._last[name] = self._clock()
            return counter[event]

    def count(self, name: str, by: int = 1) -> int:
        """Add to a named counter; return the total."""
        with self._lock:
            self._named[name] += by
            return self._named[name]

    def report(self, **values: Value) -> None:
        """Set current values."""
        with self._lock:
            self._values.update(values)

    def snapshot(self) -> dict[str, Any]:
        """Return everything as a JSON-able dict; ``age_ms`` is the time since the last message."""
        with self._lock:
            now = self._clock()
            return {
                "topics": {
                    name: {**counter, "age_ms": self._age_ms(name, now)}
                    for name, counter in sorted(self._topics.items())
                },
                "counters": dict(sorted(self._named.items())),
                "values": dict(sorted(self._values.items())),
            }

    def _age_ms(self, name: str, now: float) -> int | None:
        return round(1000 * (now - self._last[name])) if name in self._last else None
