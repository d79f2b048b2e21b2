"""The graph in numbers, in the form that Prometheus and OpenMetrics readers take."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any

from prometheus_client import CollectorRegistry
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.openmetrics.exposition import generate_latest
from prometheus_client.registry import Collector

from sceneq_tools.status import FLOWS, HeardNodes, NodeStatus

MIB = 2**20


class GraphCollector(Collector):
    """Turns heartbeats into metric families whenever somebody reads them."""

    def __init__(self, heard: HeardNodes) -> None:
        self._heard = heard

    def collect(self) -> Iterable[Metric]:
        """Yield every family once."""
        nodes = self._heard.nodes()
        yield from (_gauge(*family, nodes) for family in GAUGES)
        yield _messages(nodes)
        yield _events(nodes)
        yield _values(nodes)


def as_text(heard: HeardNodes) -> str:
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
