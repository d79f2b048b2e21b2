"""A simulated robot in the real graph; people change the room while it looks."""

import json
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sceneq_nodes._client import Client

from support.live_graph import LiveGraph

pytestmark = pytest.mark.integration

ROOM = "{kind: sim, room: bedroom, seed: 5, models: shapes, width: 320, height: 240, rate_hz: 10}"
GRAPH = f"""\
scene: bedroom
watchdog: {{silent_s: 60.0}}
nodes:
  - id: ingest
    params: {{source: {ROOM}, rate_hz: 10, keyframes: {{kind: every, every: 5}}, wait_s: 120}}
  - id: segmentation
  - id: mapping
  - id: views
  - id: encoding
    params: {{encoder: {{kind: hash}}}}
  - id: routing
    params: {{encoder: {{kind: hash}}, labels: [mug, bed, table, wall, floor]}}
"""
NEAR_M = 0.25
SEEN_PIXELS = 60
"""Of 320x240: a mug across the room."""


@pytest.fixture
def live(tmp_path: Path) -> Iterator[LiveGraph]:
    graph = tmp_path / "graph.yaml"
    graph.write_text(GRAPH)
    with tempfile.TemporaryDirectory(prefix="sq") as runtime:
        live = LiveGraph(graph, None, Path(runtime))
        try:
            yield live
        finally:
            assert live.close() == 0


def sim(live: LiveGraph, *arguments: str) -> dict[str, Any]:
    done = live.sceneq("sim", *arguments, "--json")
    assert done.returncode == 0, done.stderr
    reply: dict[str, Any] = json.loads(done.stdout)
    return reply


def get(client: Client, selector: str) -> dict[str, Any]:
    """Ask without starting a process: the machine has enough to do."""
    replies, _ = client.get(selector)
    reply: dict[str, Any] = json.loads(replies[-1][1].payload) if replies else {}
    return reply


def is_seen(client: Client, thing_id: int) -> bool:
    """Whether the newest picture, of the room as it is now, shows the thing."""
    things = get(client, "sceneq/ctl/ingest/list").get("things", ())
    return any(t["id"] == thing_id and t["pixels"] >= SEEN_PIXELS for t in things)


def is_answered(client: Client, centre_m: list[float]) -> bool:
    """Whether one of the ten best instances for what is red is where the simulation says.

    The test's encoder knows colours only, and other things in the room are as red: which of
    them comes first is chance.
    """
    return is_among(answered(client), centre_m)


def answered(client: Client) -> list[dict[str, Any]]:
    return list(get(client, "sceneq/query/bedroom/instances?q=red;k=10").get("instances", ()))


def is_among(instances: list[dict[str, Any]], centre_m: list[float]) -> bool:
    return any(np.linalg.norm(np.subtract(one["centre"], centre_m)) < NEAR_M for one in instances)


@pytest.mark.timeout(600)
def test_the_answer_follows_a_thing_that_is_moved(live: LiveGraph) -> None:
    client = live.client
    live.wait(lambda: "all 6 nodes are ready" in live.log.read_text())
    live.wait(lambda: get(client, "sceneq/ctl/ingest/list").get("things"))
    mug = sim(live, "add", "coffee mug", "--onto", "bed", "--colour", "red")
    assert (mug["on"], mug["colour"]) == ("bed", "red")
    sim(live, "look", "red mug")
    live.wait(lambda: is_answered(client, mug["centre_m"]))

    before = answered(client)
    moved = sim(live, "move", "red mug", "--onto", "stool")
    assert (moved["id"], moved["on"]) == (mug["id"], "stool")
    assert np.linalg.norm(np.subtract(moved["centre_m"], mug["centre_m"])) > 2 * NEAR_M
    assert not is_among(before, moved["centre_m"])
    sim(live, "look", str(mug["id"]))
    live.wait(lambda: is_seen(client, mug["id"]))
    live.wait(lambda: is_answered(client, moved["centre_m"]))

    (listed,) = live.zenoh_get("sceneq/ctl/ingest/list")
    assert next(t["on"] for t in listed["things"] if t["id"] == mug["id"]) == "stool"
    assert sim(live, "remove", str(mug["id"]))["gone"] == [mug["id"]]
    refused = live.sceneq("sim", "look", "red mug")
    assert refused.returncode == 1
    assert refused.stderr.startswith("sceneq: there is no 'red mug'")
