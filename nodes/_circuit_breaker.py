"""Leaves a server alone that keeps failing, so that questions do not wait for it in vain."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from sceneq_core.checks import need_at_least, need_positive


@dataclass(frozen=True, slots=True)
class BreakerParams:
    """``failures`` in a row open the circuit for ``rest_s`` seconds; then one call tries again."""

    failures: int = 5
    rest_s: float = 30.0

    def __post_init__(self) -> None:
        need_at_least(self, 1, "failures")
        need_positive(self, "rest_s")


class OpenCircuitError(Exception):
    """No call now: the last ones failed."""


class CircuitBreaker:
    """Closed: calls pass. Open: none does. After the rest one probe passes and decides."""

    def __init__(self, params: BreakerParams, clock: Callable[[], float] = time.monotonic) -> None:
        self._params = params
        self._clock = clock
        self._lock = threading.Lock()
        self._failures = 0
        self._rests_until_s = 0.0
        self._last = ""

    def enter(self) -> None:
        """Let one call pass; it reports whether the server has failed or succeeded.

        Raises:
            OpenCircuitError: not now, and why.
        """
        with self._lock:
            if self._failures < self._params.failures:
                return
            left_s = self._rests_until_s - self._clock()
            if left_s > 0:
                text = f"{self._failures} failures in a row, the last: {self._last}"
                raise OpenCircuitError(f"{text}; asked again in {left_s:.0f} s")
            self._rests_until_s = self._clock() + self._params.rest_s  # for all but this probe

    def succeeded(self) -> None:
        """Close the circuit."""
        with self._lock:
            self._failures = 0

    def failed(self, why: str) -> None:
        """Count a failure; enough of them in a row open the circuit."""
        with self._lock:
            self._failures += 1
            self._last = why
            if self._failures >= self._params.failures:
                self._rests_until_s = self._clock() + self._params.rest_s
