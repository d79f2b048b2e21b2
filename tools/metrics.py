"""The graph in numbers, in the form that Prometheus and OpenMetrics readers take."""

import threading
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from prometheus_client import CollectorRegistry
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.openmetrics.exposition import generate_latest
from prometheus_client.registry import Collector

from sceneq_nodes._client import Client
from sceneq_schemas.topics import HEALTH
from sceneq_tools.status import FLOWS, NodeStatus, from_health

SILENT_S = 5.0
"""A node that has not been heard for so long is not up, whatever it said last."""
MIB = 2**20


class Heard:
    """The newest heartbeat of every node, kept up to date by a client."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._newest: dict[str, tuple[float, NodeStatus]] = {}

    def listen(self, client: Client) -> None:
        """Take what ``client`` hears from now on."""
        client.subscribe(HEALTH.selector(), lambda key, _, payload: self.take(key, payload))

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


class GraphCollector(Collector):
    """Turns heartbeats into metric families whenever somebody reads them."""

    def __init__(self, heard: Heard) -> None:
        self._heard = heard

    def collect(self) -> Iterable[Metric]:
        """Yield every family once."""
        nodes = self._heard.nodes()
        yield from (_gauge(*family, nodes) for family in GAUGES)
        yield _messages(nodes)
        yield _events(nodes)
        yield _values(nodes)


def as_text(heard: Heard) -> str:
    """Return everything as OpenMetrics text."""
    registry = CollectorRegistry()
    registry.register(GraphCollector(heard))
    text: bytes = generate_latest(registry)  # type: ignore[no-untyped-call]
    return text.decode()


Nodes = list[tuple[NodeStatus, bool]]

GAUGES: tuple[tuple[str, str, Callable[[NodeStatus, bool], float | None]], ...] = (
    ("up", "1 while the node is ready and heard", lambda _, up: float(up)),
    ("uptime_seconds", "since the process started", lambda node, _: node.uptime_s),
    ("idle_seconds", "since the newest message", lambda node, _: node.idle_s),
    ("memory_bytes", "resident memory", lambda node, _: _bytes(node.rss_mb)),
    ("waiting_messages", "in the inbox, not taken yet", lambda node, _: float(node.waiting)),
)


def _gauge(
    name: str, says: str, value: Callable[[NodeStatus, bool], float | None], nodes: Nodes
) -> Metric:
    family = GaugeMetricFamily(f"sceneq_node_{name}", says, labels=("node", "kind"))
    for node, up in nodes:
        if (number := value(node, up)) is not None:
            family.add_metric((node.node, node.kind), number)
    return family


def _messages(nodes: Nodes) -> Metric:
    says = "in, out, dropped by a full inbox, undecodable"
    family = CounterMetricFamily("sceneq_messages", says, labels=("node", "flow"))
    for node, _ in nodes:
        for flow in FLOWS:
            family.add_metric((node.node, flow), node.flows.get(flow, 0))
    return family


def _events(nodes: Nodes) -> Metric:
    family = CounterMetricFamily("sceneq_events", "what a node counts", labels=("node", "event"))
    for node, _ in nodes:
        for name, count in _numbers(node.counters):
            family.add_metric((node.node, name), count)
    return family


def _values(nodes: Nodes) -> Metric:
    family = GaugeMetricFamily("sceneq_value", "what a node reports", labels=("node", "value"))
    for node, _ in nodes:
        for name, number in _numbers(node.values):
            family.add_metric((node.node, name), number)
    return family


def _numbers(values: Any) -> Iterator[tuple[str, float]]:
    for name, value in sorted(values.items()):
        if isinstance(value, int | float) and not isinstance(value, bool):
            yield name, float(value)


def _bytes(mib: float | None) -> float | None:
    return None if mib is None else mib * MIB
