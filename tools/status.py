"""How the nodes of a graph are, gathered from their heartbeats and liveliness tokens."""

import json
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from sceneq_nodes._client import Client
from sceneq_schemas.topics import HEALTH

LISTEN_S = 1.6
"""A little more than the second between two heartbeats."""
PATIENCE_S = 5.0
"""How long the heartbeat of a node that is alive is waited for: a busy machine's come late."""
LOOK_S = 0.05
SILENT_S = 5.0
"""A node that has not been heard for so long is not up, whatever it said last."""
FLOWS = ("in", "out", "dropped", "undecodable")


@dataclass(frozen=True, slots=True)
class NodeStatus:
    """One node; ``silent`` = it holds its liveliness token but did not say anything."""

    node: str
    kind: str
    state: str
    pid: int | None
    uptime_s: float | None
    idle_s: float | None
    rss_mb: float | None
    waiting: int
    flows: Mapping[str, int]
    counters: Mapping[str, Any]
    values: Mapping[str, Any]

    def as_json(self) -> dict[str, Any]:
        """Return the fields."""
        return asdict(self)


def node_status(client: Client) -> list[NodeStatus]:
    """Listen until all nodes that are alive were heard and return every node, by name."""
    heard = HeardNodes()
    alive = heard.listen_to_all(client)
    told = {status.node: status for status, _ in heard.nodes()}
    silent = {node: _silent(node, pid) for node, pid in alive.items() if node not in told}
    return [status for _, status in sorted({**told, **silent}.items())]


class HeardNodes:
    """The newest heartbeat of every node, kept up to date by a client."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._newest: dict[str, tuple[float, NodeStatus]] = {}

    def listen(self, client: Client) -> None:
        """Take what ``client`` hears from now on."""
        client.subscribe(HEALTH.selector(), lambda key, _, payload: self.take(key, payload))

    def listen_to_all(self, client: Client) -> dict[str, str]:
        """Listen for ``LISTEN_S``, and on until everybody was heard; return who is alive.

        At most ``PATIENCE_S`` seconds: a node that hangs is alive, too, and says nothing.
        """
        began_s = self._clock()
        self.listen(client)
        alive = {token["node"]: token["id"] for token in client.alive()}
        time.sleep(LISTEN_S)
        until_s = began_s + PATIENCE_S
        while any(node not in self._newest for node in alive) and self._clock() < until_s:
            time.sleep(LOOK_S)
        return alive

    def take(self, key: str, payload: bytes) -> None:
        """Keep a heartbeat; anything else is none."""
        if (status := from_health(key, payload)) is not None:
            with self._lock:
                self._newest[status.node] = (self._clock(), status)

    def nodes(self) -> list[tuple[NodeStatus, bool]]:
        """Return every node ever heard with whether it is up, by name."""
        with self._lock:
            newest = sorted(self._newest.items())
        now = self._clock()
        return [
            (status, status.state == "ready" and now - at < SILENT_S) for _, (at, status) in newest
        ]


def from_health(key: str, payload: bytes) -> NodeStatus | None:
    """Return what a heartbeat says, ``None`` when it is not one."""
    ids = HEALTH.ids(key)
    try:
        return None if ids is None else _told(ids["node"], json.loads(payload))
    except (ValueError, TypeError, AttributeError, RecursionError):
        return None


def _told(node: str, health: Any) -> NodeStatus:
    """Return the fields of a health message; what is none of ours fails in one of many ways."""
    topics = health.get("topics") or {}
    ages = [flow["age_ms"] for flow in topics.values() if flow.get("age_ms") is not None]
    return NodeStatus(
        node=node,
        kind=str(health.get("kind", "")),
        state=str(health.get("state", "")),
        pid=health.get("pid"),
        uptime_s=health.get("uptime_s"),
        idle_s=min(ages) / 1000 if ages else None,
        rss_mb=health.get("rss_mb"),
        waiting=sum((health.get("inbox") or {}).values()),
        flows={name: sum(flow.get(name, 0) for flow in topics.values()) for name in FLOWS},
        counters=health.get("counters") or {},
        values=health.get("values") or {},
    )


def _silent(node: str, token: str) -> NodeStatus:
    pid = int(token) if token.isdigit() else None
    nothing: dict[str, int] = {}
    return NodeStatus(node, "", "silent", pid, None, None, None, 0, nothing, nothing, nothing)
