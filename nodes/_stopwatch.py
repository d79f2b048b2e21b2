"""The time a query takes, stage by stage."""

import time


class Stopwatch:
    """Milliseconds per stage of one query."""

    def __init__(self) -> None:
        self._start_s = self._last_s = time.perf_counter()
        self.stage_ms: dict[str, float] = {}

    def lap(self, stage: str) -> None:
        """Book the time since the last lap on ``stage``."""
        now_s = time.perf_counter()
        spent_ms = (now_s - self._last_s) * 1e3
        self.stage_ms[stage] = self.stage_ms.get(stage, 0.0) + spent_ms
        self._last_s = now_s

    def total_ms(self) -> float:
        """Return the time since the start."""
        return (time.perf_counter() - self._start_s) * 1e3
