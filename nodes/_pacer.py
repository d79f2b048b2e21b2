"""Playing at a fixed rate."""


class Pacer:
    """Says when the next frame is due; all clock values, in seconds, come from the caller.

    The schedule starts with the first frame and never shifts: after a delay the frames that fell
    due meanwhile follow at once.
    """

    def __init__(self, rate_hz: float) -> None:
        self._period_s = 1.0 / rate_hz
        self._start_s: float | None = None
        self._taken = 0

    def is_due(self, now_s: float) -> bool:
        """Tell whether it is time for the next frame."""
        return now_s >= self._due_s(now_s)

    def take(self, now_s: float) -> bool:
        """Take the due frame; true when it is late, a period or more behind its time."""
        due_s = self._due_s(now_s)
        self._start_s = due_s if self._start_s is None else self._start_s
        self._taken += 1
        return now_s - due_s >= self._period_s

    def _due_s(self, now_s: float) -> float:
        return now_s if self._start_s is None else self._start_s + self._taken * self._period_s
