"""Cameras and robots that show a room, live: each becomes the map, and answers a question."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sceneq_core.ingest.transforms import inverse
from sceneq_tools.local_bus import LocalBus

from support import fake_cameras as fake
from support import lidar_street as street
from support.asked_map import centre_of, live_batch, play_live
from support.fake_bus import FakeForeign
from support.live_graph import write_graph
from support.realsense_recording import record_realsense
from support.room_layouts import FRAMES, RED_BALL_M, ROOM, shot, show_room
from support.ros_robot import Robot, stamps_ns

NEAR_M = 0.15
SIZED = {"width": ROOM.size[0], "height": ROOM.size[1]}
FAKES: dict[str, tuple[str, Callable[[fake.Wall], Any]]] = {
    "realsense": ("pyrealsense2", fake.realsense),
    "oak": ("depthai", fake.depthai),
    "orbbec": ("pyorbbecsdk", fake.orbbec),
    "record3d": ("record3d", fake.record3d),
}
LIDAR_GRAPH = Path(__file__).parents[2] / "docs" / "examples" / "lidar.yaml"
SCANS, CAR_M, CAR_NEAR_M = 10, np.array([9.0, 3.2]), 2.0
"""Of a car of 4 m only the sides that the LiDAR passed are in the map."""


@pytest.fixture(autouse=True)
def cameras_show_the_room(monkeypatch: pytest.MonkeyPatch) -> None:
    show_room(monkeypatch)


@pytest.fixture
def graph(tmp_path: Path) -> Path:
    return write_graph(tmp_path, tmp_path, segmenter="rgbd")


def red_seen(graph: Path, spec: dict[str, Any], more: Callable[[], None]) -> np.ndarray:
    """Return where the map of a camera has the red thing."""
    batch = live_batch(graph, spec)
    try:
        play_live(batch, FRAMES, more)
        assert batch.troubles() == {}
        return centre_of(batch, "red")
    finally:
        batch.close()


def in_first_camera(points_world: np.ndarray) -> np.ndarray:
    """Return points in the world of odometry."""
    T_camera_world = inverse(shot(0)[2])
    return T_camera_world[:3, :3] @ points_world + T_camera_world[:3, 3]


@pytest.mark.parametrize("maker", sorted(FAKES))
def test_a_camera_becomes_a_map(maker: str, graph: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wall = fake.Wall(FRAMES)
    module, make = FAKES[maker]
    monkeypatch.setitem(sys.modules, module, make(wall))
    is_phone = maker == "record3d"

    def more() -> None:
        if is_phone:
            wall.stream.send()

    red = red_seen(graph, {"kind": maker, **({} if is_phone else SIZED)}, more)
    expected = RED_BALL_M if is_phone else in_first_camera(RED_BALL_M)
    assert np.linalg.norm(red - expected) < NEAR_M
    assert (wall.opened, wall.closed) == (1, 1)


def test_what_librealsense_recorded_becomes_a_map(graph: Path, tmp_path: Path) -> None:
    rs = pytest.importorskip("pyrealsense2")
    path = tmp_path / "room.db3"
    record_realsense(rs, path, FRAMES, pause_s=0.0)
    spec = {"kind": "realsense", "playback": str(path), "lossless": True}
    red = red_seen(graph, spec, lambda: None)
    assert np.linalg.norm(red - in_first_camera(RED_BALL_M)) < NEAR_M


@pytest.fixture
def network(monkeypatch: pytest.MonkeyPatch) -> FakeForeign:
    """The keys of others, in lists, on the bus of one process."""
    foreign = FakeForeign()
    monkeypatch.setattr(LocalBus, "foreign", foreign, raising=False)
    return foreign


def test_a_lidar_of_a_robot_becomes_a_map(tmp_path: Path, network: FakeForeign) -> None:
    graph = tmp_path / "graph.yaml"
    graph.write_text(LIDAR_GRAPH.read_text().replace("conse", "hash"))
    topics = {"colour_topic": "/cam/image_raw", "points_topic": "/points"}
    batch = live_batch(graph, {"kind": "ros2", "domain": 7, **topics})
    try:
        drive(Robot(), network)
        play_live(batch, SCANS)
        assert batch.troubles() == {}
        assert np.linalg.norm(centre_of(batch, "red")[:2] - CAR_M) < CAR_NEAR_M
    finally:
        batch.close()


def drive(robot: Robot, network: FakeForeign) -> None:
    """Say all that a robot says on a drive, and where its camera is on the LiDAR."""

    def send(topic: str, message: Any, stamp_ns: int = 0) -> None:
        key = robot.key(topic, message.__msgtype__)
        assert network.arrive(key, robot.data(message), robot.attachment(stamp_ns)) == 1

    seen, T_lidar_camera = street.Street(), inverse(street.T_CAMERA_LIDAR)
    turn = Rotation.from_matrix(T_lidar_camera[:3, :3]).as_quat()
    send("/tf_static", robot.tf((0, "lidar", "cam", T_lidar_camera[:3, 3], turn)))
    send("/cam/camera_info", robot.info(street.K, street.CAMERA.size, frame="cam"))
    for k, stamp_ns in enumerate(stamps_ns(SCANS)):
        send("/cam/image_raw", robot.image(seen.picture(k)[0], "rgb8", stamp_ns, "cam"), stamp_ns)
        columns = dict(zip(("x", "y", "z", "intensity"), seen.scan(k).T, strict=True))
        send("/points", robot.cloud(columns, stamp_ns, "lidar"), stamp_ns)
