"""Flow control by acknowledgement: so many keyframes are on their way, none is given up easily."""

from dataclasses import dataclass
from typing import Generic, TypeVar

M = TypeVar("M")


@dataclass(slots=True)
class _InFlight(Generic[M]):
    message: M
    due_s: float
    sent: int = 1


class Window(Generic[M]):
    """Messages in flight by ``seq``, at most ``size``; all clock values come from the caller.

    A message is overdue after ``resend_s`` without ANY acknowledgement: as long as the graph
    answers, it is busy, and sending again would only add to its work. The wait doubles with every
    try; after ``tries`` the message is lost. The first message goes alone: routes to new readers
    may still be settling, and if it were sent again after the second, the order would be another.
    """

    def __init__(self, size: int, resend_s: float, tries: int) -> None:
        self._size = size
        self._resend_s = resend_s
        self._tries = tries
        self._in_flight: dict[int, _InFlight[M]] = {}
        self._answered = False

    def __len__(self) -> int:
        return len(self._in_flight)

    def has_room(self) -> bool:
        """Tell whether one more may be sent."""
        return len(self._in_flight) < (self._size if self._answered else 1)

    def sent(self, seq: int, message: M, now_s: float) -> None:
        """Remember a message until it is acknowledged."""
        self._in_flight[seq] = _InFlight(message, now_s + self._resend_s)

    def acknowledge(self, seq: int, now_s: float) -> None:
        """Forget message ``seq`` and give the others more time; unknown ones are no matter."""
        if self._in_flight.pop(seq, None) is None:
            return
        self._answered = True
        for waiting in self._in_flight.values():
            waiting.due_s = max(waiting.due_s, now_s + self._resend_s)

    def overdue(self, now_s: float) -> list[M]:
        """Return what has to be sent again now, oldest first."""
        late = [w for w in self._in_flight.values() if w.due_s <= now_s and w.sent < self._tries]
        for waiting in late:
            waiting.due_s = now_s + self._resend_s * 2**waiting.sent
            waiting.sent += 1
        return [waiting.message for waiting in late]

    def lost(self, now_s: float) -> list[int]:
        """Forget and return the seqs that were sent often enough in vain."""
        given_up = [
            seq
            for seq, waiting in self._in_flight.items()
            if waiting.due_s <= now_s and waiting.sent >= self._tries
        ]
        for seq in given_up:
            self._answered = True
            del self._in_flight[seq]
        return given_up
