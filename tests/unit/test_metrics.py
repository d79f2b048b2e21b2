"""Heartbeats as numbers for Prometheus, and rates of counters."""

import json

import pytest
from prometheus_client.openmetrics.parser import text_string_to_metric_families

from sceneq_tools.errors import UserError
from sceneq_tools.metrics import as_text
from sceneq_tools.metrics_command import _address
from sceneq_tools.rates import Rates
from sceneq_tools.status import SILENT_S, HeardNodes

KEY = "sceneq/health/mapping"
BEAT = {
    "node": "mapping",
    "kind": "mapping",
    "pid": 7,
    "state": "ready",
    "uptime_s": 12.5,
    "busy_s": 0.0,
    "rss_mb": 2.0,
    "inbox": {"a": 1, "b": 2},
    "topics": {"mask": {"in": 5, "dropped": 1, "age_ms": 250}, "map_delta": {"out": 4}},
    "counters": {"frames_integrated": 4},
    "values": {"voxels": 1000, "state": "playing"},
}


class Clock:
    now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


def samples(heard: HeardNodes) -> dict[tuple[str, ...], float]:
    """Return the value of every sample by its name and label values."""
    families = text_string_to_metric_families(as_text(heard))
    found = [s for family in families for s in family.samples]
    return {(s.name, *(_labels(s.labels))): s.value for s in found}


def _labels(labels: dict[str, str]) -> tuple[str, ...]:
    """Return the node, then the other label."""
    rest = (value for name, value in sorted(labels.items()) if name != "node")
    return labels["node"], *rest


def test_a_heartbeat_becomes_samples_that_the_usual_parser_reads() -> None:
    heard = HeardNodes(Clock())
    heard.take(KEY, json.dumps(BEAT).encode())
    said = samples(heard)
    assert said["sceneq_node_up", "mapping", "mapping"] == 1
    assert said["sceneq_node_uptime_seconds", "mapping", "mapping"] == 12.5
    assert said["sceneq_node_idle_seconds", "mapping", "mapping"] == 0.25
    assert said["sceneq_node_memory_bytes", "mapping", "mapping"] == 2 * 2**20
    assert said["sceneq_node_waiting_messages", "mapping", "mapping"] == 3
    assert said["sceneq_messages_total", "mapping", "in"] == 5
    assert said["sceneq_messages_total", "mapping", "dropped"] == 1
    assert said["sceneq_events_total", "mapping", "frames_integrated"] == 4
    assert said["sceneq_value", "mapping", "voxels"] == 1000
    assert ("sceneq_value", "mapping", "state") not in said  # a word is no number


def test_a_node_that_is_silent_or_not_ready_is_not_up() -> None:
    clock = Clock()
    heard = HeardNodes(clock)
    heard.take(KEY, json.dumps({**BEAT, "state": "starting"}).encode())
    assert samples(heard)["sceneq_node_up", "mapping", "mapping"] == 0
    heard.take(KEY, json.dumps(BEAT).encode())
    assert samples(heard)["sceneq_node_up", "mapping", "mapping"] == 1
    clock.now_s += SILENT_S
    assert samples(heard)["sceneq_node_up", "mapping", "mapping"] == 0


def test_what_is_no_heartbeat_is_not_taken() -> None:
    heard = HeardNodes(Clock())
    for payload in (b"", b"[]", b"\xff", b"nan", b"[" * 10_000):
        heard.take(KEY, payload)
    heard.take("sceneq/else/mapping", json.dumps(BEAT).encode())
    assert heard.nodes() == []
    assert as_text(heard).endswith("# EOF\n")


def test_rates_are_growth_a_second() -> None:
    rates = Rates()
    assert rates.of("mapping", {"in": 10}, 1.0) == {}
    assert rates.of("mapping", {"in": 16}, 3.0) == {"in": 3.0}
    assert rates.of("views", {"in": 5}, 3.0) == {}
    assert rates.of("mapping", {"in": 2}, 4.0) == {}  # it has started again
    assert rates.of("mapping", {"in": 4}, 5.0) == {"in": 2.0}


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("9464", ("127.0.0.1", 9464)),
        ("0.0.0.0:9464", ("0.0.0.0", 9464)),
        ("[::1]:80", ("::1", 80)),
    ],
)
def test_an_address_is_a_port_or_a_host_with_one(text: str, address: tuple[str, int]) -> None:
    assert _address(text) == address


@pytest.mark.parametrize("text", ["", "host", "host:", "99999", "host:-1"])
def test_anything_else_is_refused(text: str) -> None:
    with pytest.raises(UserError, match="expected PORT or HOST:PORT"):
        _address(text)
