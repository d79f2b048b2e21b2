"""A robot in a process of its own speaks ROS 2; a map results, and ROS messages of it come back."""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sceneq_nodes._client import Client
from sceneq_nodes._runtime import close, open_session
from sceneq_nodes.ros.keys import unpack_attachment
from sceneq_nodes.ros.point_cloud import cloud_columns
from sceneq_nodes.ros.typestore import typestore

from support.live_graph import LiveGraph

pytestmark = pytest.mark.integration

VIEWS = 14
TOPICS = "/cam/color/image_raw,/cam/aligned_depth_to_color/image_raw"
SOURCE = f"ros2:{TOPICS},domain=7,world=map,patience=600"
"""The robot is silent before all nodes are ready and after its last view: no trouble of ours."""
GRAPH = """\
nodes:
  - id: ingest
    params:
      source: {kind: folder, path: .}
      keyframes: {kind: every, every: 1}
  - id: segmentation
    params: {segmenter: {kind: rgbd}}
  - id: mapping
  - id: views
  - id: encoding
    params: {encoder: {kind: hash}}
  - id: routing
    params: {encoder: {kind: hash}, labels: [ball, box, table, wall, floor]}
  - id: ros
    params: {domain: 7, repeat_s: 1.0}
"""
TYPES = {
    "detections": "vision_msgs/msg/Detection3DArray",
    "markers": "visualization_msgs/msg/MarkerArray",
    "cloud": "sensor_msgs/msg/PointCloud2",
}
RED_BALL_M = np.array([-0.35, 0.95, 0.84])


@pytest.fixture
def live(tmp_path: Path) -> Iterator[LiveGraph]:
    graph = tmp_path / "graph.yaml"
    graph.write_text(GRAPH)
    with tempfile.TemporaryDirectory(prefix="sq") as runtime:
        live = LiveGraph(graph, None, Path(runtime), "--source", SOURCE, "--rate", "0")
        try:
            yield live
        finally:
            assert live.close() == 0


class Robot:
    """The publishing process."""

    def __init__(self, endpoint: str, dialect: str) -> None:
        folder = Path(__file__).parents[1]
        self._process = subprocess.Popen(
            [sys.executable, "-m", "support.ros_publisher", endpoint, dialect, str(VIEWS)],
            cwd=folder,
            env=os.environ | {"PYTHONPATH": str(folder)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == "ready\n"

    def tell(self) -> None:
        """Go on: play the views, and the second time end."""
        assert self._process.stdin is not None
        self._process.stdin.write("\n")
        self._process.stdin.flush()

    def end(self) -> None:
        self._process.kill()
        self._process.communicate()


@pytest.mark.timeout(400)
def test_a_robot_becomes_a_map_and_gets_it_back(live: LiveGraph) -> None:
    assert live.client  # the router is there
    robot = Robot(live.endpoint, "jazzy")
    heard: dict[str, list[tuple[bytes, bytes]]] = {}
    session = open_session(live.endpoint, 10.0)
    try:
        live.wait(lambda: "all 7 nodes are ready" in live.log.read_text())
        session.declare_subscriber("7/scene_q/**", lambda sample: _keep(heard, sample))
        robot.tell()
        with Client(live.endpoint) as client:
            best = live.wait(lambda: _red_ball(client))
        assert np.linalg.norm(np.subtract(best["centre"], RED_BALL_M)) < 0.15
        live.wait(lambda: live.value("ingest", "frames") == VIEWS)
        told = live.wait(lambda: _told(heard))
        _check_status(live)
        _check_tokens(session)
    finally:
        robot.end()
        close(session)
    _check_results(heard, told)


def _keep(heard: dict[str, list[tuple[bytes, bytes]]], sample: Any) -> None:
    said = sample.payload.to_bytes(), sample.attachment.to_bytes()
    heard.setdefault(str(sample.key_expr), []).append(said)


def _red_ball(client: Client) -> dict[str, Any] | None:
    replies, _ = client.get("sceneq/query/robot/instances?q=red;k=10")
    body = json.loads(replies[-1][1].payload) if replies else {}
    near = [
        one
        for one in body.get("instances", ())
        if np.linalg.norm(np.subtract(one["centre"], RED_BALL_M)) < 0.15
    ]
    return near[0] if near else None


def _told(heard: dict[str, list[tuple[bytes, bytes]]]) -> int:
    """Return how many messages there are of each topic once the newest say and name the ball."""
    said = {key.split("/")[2]: messages for key, messages in heard.items()}
    count = min((len(messages) for messages in said.values()), default=0)
    if set(said) != set(TYPES) or not count:
        return 0
    newest = {name: _decoded(name, messages[count - 1]) for name, messages in said.items()}
    named = {marker.id for marker in newest["markers"].markers if marker.ns == "names"}
    balls = [one for one in newest["detections"].detections if _is_red_ball(one)]
    return count if any(int(one.id) in named for one in balls) else 0


def _decoded(name: str, message: tuple[bytes, bytes]) -> Any:
    return typestore("jazzy").decode(TYPES[name], message[0])


def _is_red_ball(detection: Any) -> bool:
    at = detection.bbox.center.position
    return bool(np.linalg.norm(np.array([at.x, at.y, at.z]) - RED_BALL_M) < 0.15)


def _check_status(live: LiveGraph) -> None:
    ingest = live.heard()["ingest"]
    assert ingest.values["trouble"] == ""
    assert not [name for name in ingest.counters if name.startswith("ros_")]
    assert ingest.values["frames"] == VIEWS


def _check_tokens(session: Any) -> None:
    tokens = {str(r.ok.key_expr) for r in session.liveliness().get("@ros2_lv/7/**") if r.ok}
    assert any(token.endswith("/0/0/NN/%/%/sceneq") for token in tokens)
    assert any("/MP/%/%/sceneq/%scene_q%detections/vision_msgs::msg" in t for t in tokens)


def _check_results(heard: dict[str, list[tuple[bytes, bytes]]], told: int) -> None:
    store = typestore("jazzy")
    last = {}
    for name, kind in TYPES.items():
        package, _, short = kind.split("/")
        key = f"7/scene_q/{name}/{package}::msg::dds_::{short}_/{store.hash(kind)}"
        attached = [unpack_attachment(attachment) for _, attachment in heard[key]]
        assert [a.seq for a in attached] == list(range(1, len(attached) + 1))
        assert len({a.gid for a in attached}) == 1
        last[name] = _decoded(name, heard[key][told - 1])
    detections = last["detections"].detections
    assert last["detections"].header.frame_id == "map"
    ball = next(one for one in detections if _is_red_ball(one))
    assert 0.1 < ball.bbox.size.x < 0.4
    named = {(m.ns, m.id) for m in last["markers"].markers}
    assert {("all", 0), ("boxes", int(ball.id)), ("names", int(ball.id))} <= named
    cloud = cloud_columns(last["cloud"])
    own = cloud["instance_id"] == int(ball.id)
    assert own.sum() > 20
    assert np.abs(cloud["x"][own].mean() - RED_BALL_M[0]) < 0.1
