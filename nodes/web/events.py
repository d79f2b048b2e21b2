"""What happens, to every page that listens; a slow page loses the oldest and is told so."""

import asyncio
import threading
from collections import deque
from collections.abc import Mapping
from typing import Any

MAX_WAITING = 256

Event = Mapping[str, Any]


class Listener:
    """The events that wait for one page; ``take`` runs in its event loop, ``put`` anywhere."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._waiting: deque[Event] = deque(maxlen=MAX_WAITING)
        self._something = asyncio.Event()
        self._lost = 0
        self._lock = threading.Lock()

    def put(self, event: Event) -> None:
        """Tell ``event``; never waits."""
        with self._lock:
            self._lost += len(self._waiting) == MAX_WAITING
            self._waiting.append(event)
        self._loop.call_soon_threadsafe(self._something.set)

    async def take(self) -> list[Event]:
        """Return what happened since, oldest first; wait until something has."""
        await self._something.wait()
        with self._lock:
            self._something.clear()
            events, lost = list(self._waiting), self._lost
            self._waiting.clear()
            self._lost = 0
        return [{"type": "lost", "count": lost}, *events] if lost else events


class Hub:
    """Tells every listener what happens."""

    def __init__(self, max_listeners: int) -> None:
        self._max = max_listeners
        self._listeners: set[Listener] = set()
        self._lock = threading.Lock()

    @property
    def count(self) -> int:
        """How many listen."""
        return len(self._listeners)

    def tell(self, event: Event) -> None:
        """Tell all of them; may be called from any thread."""
        with self._lock:
            listeners = list(self._listeners)
        for listener in listeners:
            listener.put(event)

    def join(self) -> Listener | None:
        """Return a new listener of the running event loop; ``None`` when there are enough."""
        listener = Listener(asyncio.get_running_loop())
        with self._lock:
            if len(self._listeners) >= self._max:
                return None
            self._listeners.add(listener)
        return listener

    def leave(self, listener: Listener) -> None:
        """Tell it nothing more."""
        with self._lock:
            self._listeners.discard(listener)
