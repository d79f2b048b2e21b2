"""What the nodes of a graph say about themselves, heard over the bus."""

import contextlib
import json
import queue
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from sceneq_schemas.topics import HEALTH

if TYPE_CHECKING:
    from sceneq_nodes._client import Client

CONNECT_S = 1.0
CAPACITY = 1024
"""More heartbeats than a minute of any graph; nobody drains: the rest is dropped."""


class Heartbeats:
    """Health messages at one endpoint; the router may come and go.

    Args:
        endpoint: the router, such as ``tcp/127.0.0.1:7447``.
    """

    def __init__(self, endpoint: str) -> None:
        self._endpoint = endpoint
        self._client: Client | None = None
        self._inbox: queue.Queue[tuple[str, bytes]] = queue.Queue(CAPACITY)

    def drain(self) -> Iterator[tuple[str, Mapping[str, Any]]]:
        """Yield (node, health) of what arrived; connects first, when that is still to do."""
        self._connect()
        while not self._inbox.empty():
            key, payload = self._inbox.get()
            ids = HEALTH.ids(key)
            with contextlib.suppress(ValueError, RecursionError):  # not ours: no heartbeat
                health = json.loads(payload)
                if ids is not None and isinstance(health, dict):
                    yield ids["node"], health

    def close(self) -> None:
        """Leave the bus; the process would not end without it."""
        if self._client is not None:
            self._client.close()
            self._client = None

    def _connect(self) -> None:
        from sceneq_nodes._client import Client

        if self._client is None:
            with contextlib.suppress(ConnectionError):  # the router is still starting
                self._client = Client(self._endpoint, CONNECT_S)
                self._client.subscribe(HEALTH.selector(), self._put)

    def _put(self, key: str, encoding: str, payload: bytes) -> None:
        with contextlib.suppress(queue.Full):
            self._inbox.put_nowait((key, payload))
