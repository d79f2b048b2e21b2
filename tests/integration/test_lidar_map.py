"""A drive with a LiDAR, in KITTI's files, becomes a map that can be asked about its cars."""

import json
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sceneq_nodes._client import Client

from support.lidar_street import write_kitti
from support.live_graph import LiveGraph

pytestmark = pytest.mark.integration

GRAPH = Path(__file__).parents[2] / "docs" / "examples" / "lidar.yaml"
CARS_M = {"red": (9.0, 3.2), "blue": (17.0, -3.4)}
NEAR_M = 2.0
"""Of a car of 4 m only the sides that the LiDAR passed are in the map."""


@pytest.fixture
def live(tmp_path: Path) -> Iterator[LiveGraph]:
    drive = tmp_path / "drive"
    write_kitti(drive, 12)
    graph = tmp_path / "graph.yaml"
    graph.write_text(GRAPH.read_text().replace("conse", "hash"))
    with tempfile.TemporaryDirectory(prefix="sq") as runtime:
        live = LiveGraph(graph, drive, Path(runtime), "--rate", "0")
        try:
            yield live
        finally:
            assert live.close() == 0


def _instances(client: Client, colour: str) -> list[dict[str, Any]]:
    replies, _ = client.get(f"sceneq/query/drive/instances?q={colour};k=10")
    body = json.loads(replies[-1][1].payload) if replies else {}
    return list(body.get("instances", ()))


def _found(client: Client, colour: str) -> bool:
    near = np.array(CARS_M[colour])
    return any(
        np.linalg.norm(np.array(one["centre"])[:2] - near) < NEAR_M
        for one in _instances(client, colour)
    )


def test_cars_are_found_where_they_stand(live: LiveGraph) -> None:
    live.wait_until_settled()
    assert live.value("ingest", "frames") == 12
    with Client(live.endpoint) as client:
        for colour in CARS_M:
            live.wait(lambda colour=colour: _found(client, colour))
