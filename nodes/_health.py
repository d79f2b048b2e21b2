"""Once a second every node says how it is, also while a step takes long."""

import logging
import os
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sceneq_nodes._counters import Counters

log = logging.getLogger(__name__)

PERIOD_S = 1.0
LAST_BEAT_S = 0.1

Publish = Callable[[dict[str, Any], dict[str, Any]], None]


class Health:
    """The heartbeat of one process.

    ``busy_s`` is how long the present step has been running: a node that computes still beats, one
    that hangs as a whole does not.
    """

    def __init__(
        self, kind: str, counters: Counters, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.state = "starting"
        self._kind = kind
        self._counters = counters
        self._clock = clock
        self._started = clock()
        self._step_began: float | None = None
        self._due = threading.Event()

    @contextmanager
    def step(self) -> Iterator[None]:
        """Time one step."""
        self._step_began = self._clock()
        try:
            yield
        finally:
            self._step_began = None

    def message(self, node: str, depths: dict[str, int]) -> dict[str, Any]:
        """Return the health message of this moment."""
        began = self._step_began
        return {
            "node": node,
            "kind": self._kind,
            "pid": os.getpid(),
            "state": self.state,
            "uptime_s": round(self._clock() - self._started, 3),
            "busy_s": 0.0 if began is None else round(self._clock() - began, 3),
            "rss_mb": rss_mb(),
            "inbox": depths,
            **self._counters.snapshot(),
        }

    def beat(self, publish: Callable[[], None], stop: threading.Event) -> Callable[[], None]:
        """Call ``publish`` every ``PERIOD_S`` on a thread until ``stop`` is set.

        Returns:
            What sets ``stop`` and waits for a beat that is on its way, ``LAST_BEAT_S`` at most.
        """
        heart = threading.Thread(target=self._repeat, args=(publish, stop), name="health")
        heart.daemon = True
        heart.start()

        def rest() -> None:
            stop.set()
            self.hurry()
            heart.join(LAST_BEAT_S)

        return rest

    def hurry(self) -> None:
        """Beat now: the state has changed and others wait for it."""
        self._due.set()

    def _repeat(self, publish: Callable[[], None], stop: threading.Event) -> None:
        while not stop.is_set():
            self._due.clear()
            try:
                publish()
            except Exception:
                if not stop.is_set():
                    log.exception("no heartbeat")
            self._due.wait(PERIOD_S)


def metrics(health: dict[str, Any]) -> dict[str, Any]:
    """Return the numbers of a health message under flat names such as ``mask.in``."""
    flat = {
        f"{t}.{event}": n for t, events in health["topics"].items() for event, n in events.items()
    }
    flat |= health["counters"] | health["values"]
    flat |= {name: health[name] for name in ("uptime_s", "busy_s", "rss_mb")}
    flat["inbox"] = sum(health["inbox"].values())
    return {name: value for name, value in flat.items() if isinstance(value, int | float)}


def rss_mb() -> float:
    """Return the resident memory of this process in MiB, 0 where the system does not say."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except (OSError, IndexError, ValueError):
        return 0.0
    return round(pages * os.sysconf("SC_PAGE_SIZE") / 2**20, 1)
