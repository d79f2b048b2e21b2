"""Samples between the network's threads and the source: bounded per role, in order of arrival."""

from collections import deque
from itertools import count
from threading import Lock

from sceneq_nodes._bus import ForeignSample

DEPTHS = {"tf": 2000, "tf_static": 200, "pose": 500}
IMAGES = 32


class Mailbox:
    """Where samples wait; beyond the depth of its role the oldest is dropped and counted."""

    def __init__(self) -> None:
        self._queues: dict[str, deque[tuple[int, ForeignSample]]] = {}
        self._arrival = count()
        self._lock = Lock()
        self._dropped = 0

    def put(self, role: str, sample: ForeignSample) -> None:
        """Add a sample; never blocks for long, and decodes nothing."""
        with self._lock:
            queue = self._queues.setdefault(role, deque(maxlen=DEPTHS.get(role, IMAGES)))
            self._dropped += len(queue) == queue.maxlen
            queue.append((next(self._arrival), sample))

    def take(self) -> tuple[str, ForeignSample] | None:
        """Return the oldest sample with its role, ``None`` when there is none."""
        with self._lock:
            waiting = [(queue[0][0], role) for role, queue in self._queues.items() if queue]
            if not waiting:
                return None
            role = min(waiting)[1]
            return role, self._queues[role].popleft()[1]

    def dropped(self) -> int:
        """Return how many were dropped since the last time."""
        with self._lock:
            dropped, self._dropped = self._dropped, 0
        return dropped
