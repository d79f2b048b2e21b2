"""What the nodes of a graph say about themselves, heard over the bus."""

import contextlib
import json
import queue
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from sceneq_nodes._credentials import Credentials
from sceneq_schemas.topics import HEALTH

if TYPE_CHECKING:
    from sceneq_nodes._client import Client

CONNECT_S = 1.0
CAPACITY = 1024
"""More heartbeats than a minute of any graph; nobody drains: the rest is dropped."""


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """What the launcher needs of a health message; ``doing`` is the node's own word for it."""

    node: str
    pid: int
    ready: bool
    busy_s: float
    doing: str


class Heartbeats:
    """Health messages at one endpoint; the router may come and go.

    Args:
        endpoint: the router, such as ``tcp/127.0.0.1:7447``.
        credentials: what to show there; those in the environment when not given.
    """

    def __init__(self, endpoint: str, credentials: Credentials | None = None) -> None:
        self._endpoint = endpoint
        self._credentials = credentials
        self._client: Client | None = None
        self._inbox: queue.Queue[tuple[str, bytes]] = queue.Queue(CAPACITY)

    def drain(self) -> Iterator[Heartbeat]:
        """Yield what arrived; connects first, when that is still to do."""
        self._connect()
        while not self._inbox.empty():
            if (beat := heartbeat(*self._inbox.get())) is not None:
                yield beat

    def close(self) -> None:
        """Leave the bus; the process would not end without it."""
        if self._client is not None:
            self._client.close()
            self._client = None

    def _connect(self) -> None:
        from sceneq_nodes._client import Client

        if self._client is None:
            with contextlib.suppress(ConnectionError):  # the router is still starting
                self._client = Client(self._endpoint, CONNECT_S, self._credentials)
                self._client.subscribe(HEALTH.selector(), self._put)

    def _put(self, key: str, encoding: str, payload: bytes) -> None:
        with contextlib.suppress(queue.Full):
            self._inbox.put_nowait((key, payload))


def heartbeat(key: str, payload: bytes) -> Heartbeat | None:
    """Return what a health message says; anything else on its key is no heartbeat."""
    ids = HEALTH.ids(key)
    try:
        health = json.loads(payload)
        values = health.get("values") or {}
        return Heartbeat(
            node=(ids or {})["node"],
            pid=int(health["pid"]),
            ready=health["state"] == "ready",
            busy_s=float(health.get("busy_s", 0.0)),
            doing=str(values.get("state", "")),
        )
    except (ValueError, TypeError, KeyError, AttributeError, OverflowError, RecursionError):
        return None
