"""What a visual reasoner needs of a vision-language model, wherever it runs."""

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from sceneq_core.reasoning.multiple_choice import VisualQuestion
from sceneq_core.reasoning.reasoner import NO_USAGE, Usage


@dataclass(frozen=True, slots=True)
class Replies:
    """The texts that came in time, why each of the others did not, and what all of it cost."""

    texts: tuple[str, ...]
    failures: tuple[str, ...]
    vlm_calls: int
    usage: Usage


class VisionModel(Protocol):
    """Answers questions about pictures."""

    name: str

    def ask(self, questions: Sequence[VisualQuestion], end_s: float) -> Replies:
        """Return the replies, not later than ``end_s`` on the clock ``time.monotonic``."""

    def close(self) -> None:
        """Release connections and memory."""


class Tally:
    """Adds up what the calls of one question cost, from several threads.

    A call that is abandoned is in it from its start: it may well be on the bill.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._calls = 0
        self._usage = NO_USAGE

    def add(self, usage: Usage, calls: int = 0) -> None:
        """Add calls and what they used."""
        with self._lock:
            self._calls += calls
            self._usage = self._usage + usage

    def total(self) -> tuple[int, Usage]:
        """Return calls and usage up to now."""
        with self._lock:
            return self._calls, self._usage
