"""The bounded place between the network's threads and a node's loop: newest kept, loss counted."""

import threading
from collections import deque
from dataclasses import dataclass
from itertools import count

from sceneq_schemas.topics import Topic


@dataclass(frozen=True, slots=True)
class Raw:
    """A message as it came, not decoded yet."""

    topic: Topic
    key: str
    data: bytes


class Inbox:
    """One bounded queue per key expression; ``take`` returns messages in the order they came."""

    def __init__(self) -> None:
        self._queues: dict[str, deque[tuple[int, Raw]]] = {}
        self._arrival = count()
        self._changed = threading.Condition()

    def open(self, selector: str, depth: int) -> None:
        """Keep at most ``depth`` messages for ``selector``; raise ``ValueError`` below 1."""
        if depth < 1:
            raise ValueError(f"{selector}: depth {depth} must be at least 1")
        with self._changed:
            self._queues[selector] = deque(maxlen=depth)

    def put(self, selector: str, raw: Raw) -> bool:
        """Add a message; return False when the oldest one had to go for it. Never blocks."""
        with self._changed:
            queue = self._queues[selector]
            fits = len(queue) < (queue.maxlen or 0)
            queue.append((next(self._arrival), raw))
            self._changed.notify()
        return fits

    def take(self, timeout_s: float) -> Raw | None:
        """Return the oldest message, or ``None`` when there is none for ``timeout_s``."""
        with self._changed:
            self._changed.wait_for(self._has_any, timeout_s)
            waiting = [queue for queue in self._queues.values() if queue]
            if not waiting:
                return None
            return min(waiting, key=lambda queue: queue[0][0]).popleft()[1]

    def depths(self) -> dict[str, int]:
        """Return how many messages wait per key expression."""
        with self._changed:
            return {selector: len(queue) for selector, queue in self._queues.items()}

    def _has_any(self) -> bool:
        return any(self._queues.values())
