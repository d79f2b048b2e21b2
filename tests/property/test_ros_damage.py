"""Damaged messages from a robot are said and left out; nothing of them ends the process."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_core.ingest.source import RawFrame, Skipped, Waiting
from sceneq_nodes._backends import build
from sceneq_nodes._bus import Context

from support.fake_bus import FakeBus
from support.ros_robot import NS, Robot

COLOUR, RANGE, TOPIC_OF_POSE = "/cam/image_raw", "/cam/range", "/odom"
START_NS = 1_700_000_000 * NS
STRAIGHT = (0, 0, 0, 1.0)
K = np.array([[10.0, 0, 3.5], [0, 10.0, 2.5], [0, 0, 1]])
ROBOT = Robot()


def messages(is_lidar):
    """Yield (topic, message) of one frame, whole."""
    rgb, depth = np.zeros((6, 8, 3), np.uint8), np.full((6, 8), 900, np.uint16)
    points = {name: np.linspace(-2, 2, 30).astype("f4") for name in "xyz"}
    yield "/cam/camera_info", ROBOT.info(K, (8, 6), "plumb_bob", (0.1, 0, 0, 0, 0), frame="cam")
    yield "/tf_static", ROBOT.tf((0, "base", "cam", (0, 0, 1), STRAIGHT))
    yield "/tf", ROBOT.tf((START_NS, "odom", "base", (1, 2, 3), STRAIGHT))
    yield TOPIC_OF_POSE, ROBOT.odometry((1, 2, 3), STRAIGHT, START_NS)
    yield COLOUR, ROBOT.image(rgb, "rgb8", START_NS, "cam")
    depth_image = ROBOT.image(depth, "16UC1", START_NS, "cam")
    yield RANGE, ROBOT.cloud(points, START_NS, "cam") if is_lidar else depth_image


WHOLE = {kind: [(t, m, ROBOT.data(m)) for t, m in messages(kind)] for kind in (False, True)}


@st.composite
def damaged(draw):
    """The messages of a frame with bytes changed, or an end cut off, in some."""
    is_lidar = draw(st.booleans())
    sent = []
    for topic, message, whole in WHOLE[is_lidar]:
        data = bytearray(whole)
        # The first bytes hold headers, lengths and names: there damage does most.
        reach = st.integers(0, min(len(data), 160) - 1)
        for at in draw(st.lists(reach, max_size=3)):
            data[at] = draw(st.integers(0, 255))
        cut = draw(st.sampled_from([None, None, None, 7, len(data) // 2]))
        sent.append((topic, ROBOT.key(topic, message.__msgtype__), bytes(data[:cut])))
    return is_lidar, draw(st.permutations(sent))


@settings(max_examples=80, deadline=None)
@given(damaged())
def test_damage_ends_nothing(case):
    is_lidar, sent = case
    bus = FakeBus(Context("ingest", "room", "r1", "cam"))
    ranges = {"points_topic": RANGE} if is_lidar else {"depth_topic": RANGE}
    pose = {"kind": "topic", "topic": TOPIC_OF_POSE}
    spec = {"kind": "ros2", "colour_topic": COLOUR, "domain": 7, "pose": pose, **ranges}
    source = build("source", spec)
    source.connect(bus)
    for _ in range(2):
        for _, key, data in sent:
            bus.foreign.arrive(key, data)
    frames = source.frames()
    for _ in range(20):
        frame = next(frames)
        if isinstance(frame, Waiting):
            break
        assert isinstance(frame, RawFrame | Skipped)
        if isinstance(frame, RawFrame):
            assert isinstance(frame.read_rgb(), np.ndarray | Skipped)
            assert isinstance(frame.read_depth_mm(), np.ndarray | Skipped)
