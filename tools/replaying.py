"""A recording played into a running graph by a process that ends with it."""

import signal
from typing import Any, ClassVar

from sceneq_nodes._bus import Bus, Context, Received
from sceneq_nodes.ingest import Ingest, IngestParams


class Replay:
    """What ingest does, and the end of the process when that is done."""

    Params: ClassVar[type] = IngestParams
    idle_s: ClassVar[float] = Ingest.idle_s

    def __init__(self, params: IngestParams, context: Context) -> None:
        self._ingest = Ingest(params, context)

    def open(self, bus: Bus) -> None:
        """Open the recording; raise ``ValueError`` when it cannot be played."""
        self._watched = _Watched(bus)
        self._ingest.open(self._watched)

    def step(self, received: Received | None) -> None:
        """Play what is due."""
        self._ingest.step(received)
        if self._watched.state == "finished":
            signal.raise_signal(signal.SIGTERM)

    def close(self) -> None:
        """Release the recording."""
        self._ingest.close()


class _Watched:
    """A bus that remembers what state its node says it is in."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self.state = ""

    def report(self, **values: float | int | str) -> None:
        self.state = str(values.get("state", self.state))
        self._bus.report(**values)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._bus, name)
