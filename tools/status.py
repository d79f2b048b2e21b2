"""How the nodes of a graph are, gathered from their heartbeats and liveliness tokens."""

import json
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from sceneq_nodes._client import Client
from sceneq_schemas.topics import HEALTH

LISTEN_S = 1.6
"""A little more than the second between two heartbeats."""
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
    """Listen for ``LISTEN_S`` seconds and return every node, by name."""
    heard: dict[str, NodeStatus] = {}

    def note(key: str, encoding: str, payload: bytes) -> None:
        status = from_health(key, payload)
        if status is not None:
            heard[status.node] = status

    client.subscribe(HEALTH.selector(), note)
    alive = {token["node"]: token["id"] for token in client.alive()}
    time.sleep(LISTEN_S)
    silent = {node: _silent(node, pid) for node, pid in alive.items() if node not in heard}
    return [status for _, status in sorted({**heard, **silent}.items())]


def from_health(key: str, payload: bytes) -> NodeStatus | None:
    """Return what a heartbeat says, ``None`` when it is not one."""
    ids = HEALTH.ids(key)
    try:
        health = json.loads(payload)
    except (ValueError, RecursionError):
        return None
    if ids is None or not isinstance(health, dict):
        return None
    topics = health.get("topics") or {}
    ages = [flow["age_ms"] for flow in topics.values() if flow.get("age_ms") is not None]
    return NodeStatus(
        node=ids["node"],
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
