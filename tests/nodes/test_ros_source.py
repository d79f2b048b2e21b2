"""A robot on the wire becomes frames; everything that may be wrong with it is said."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sceneq_core.ingest.source import RawFrame, RefusedError, Skipped, Waiting
from sceneq_core.ingest.transforms import inverse
from sceneq_nodes._backends import build
from sceneq_nodes._bus import Context
from sceneq_nodes.ingest import Ingest, IngestParams
from sceneq_schemas.topics import FRAME, POSE

from support import lidar_street as street
from support.fake_bus import FakeBus
from support.ros_robot import NS, Robot, stamps_ns

COLOUR, DEPTH = "/cam/color/image_raw", "/cam/depth/image_raw"
K = np.array([[100.0, 0, 7.5], [0, 100.0, 5.5], [0, 0, 1]])
SIZE = (16, 12)
STRAIGHT = np.array([0, 0, 0, 1.0])
IMAGE, INFO = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo"
TF = "tf2_msgs/msg/TFMessage"
START_NS = 1_700_000_000 * NS


class Live:
    """A source on a fake network with a robot on it."""

    def __init__(self, speaks="jazzy", **params):
        self.robot = Robot(params.get("distro", "jazzy"), speaks)
        self.bus = FakeBus(Context("ingest", "room", "r1", "cam"))
        self.now_s = 0.0
        spec = {"colour_topic": COLOUR, "depth_topic": DEPTH, "domain": 7, **params}
        cls = type(build("source", {"kind": "ros2", **spec}))
        source = build("source", {"kind": "ros2", **spec})
        self.source = cls(source._params, clock=lambda: self.now_s)
        self.source.connect(self.bus)
        self._frames = self.source.frames()

    def send(self, topic, message):
        kind, ns = message.__msgtype__, getattr(message, "header", None)
        key = self.robot.key(topic, kind)
        stamp = ns.stamp.sec * NS + ns.stamp.nanosec if ns else 0
        heard = self.bus.foreign.arrive(key, self.robot.data(message), self.robot.attachment(stamp))
        assert heard == 1, f"nobody listens to {key}"

    def infos(self, size=SIZE, frame="cam", depth_frame="cam"):
        self.send("/cam/color/camera_info", self.robot.info(K, size, frame=frame))
        self.send("/cam/depth/camera_info", self.robot.info(K, size, frame=depth_frame))

    def images(self, stamp_ns, frame="cam", depth_frame="cam", apart_ns=0, size=SIZE):
        rgb = np.full((size[1], size[0], 3), 9, np.uint8)
        depth = np.full((size[1], size[0]), 1500, np.uint16)
        self.send(COLOUR, self.robot.image(rgb, "rgb8", stamp_ns, frame))
        self.send(DEPTH, self.robot.image(depth, "16UC1", stamp_ns + apart_ns, depth_frame))

    def moved(self, stamp_ns, x, parent="map", child="cam", topic="/tf"):
        self.send(topic, self.robot.tf((stamp_ns, parent, child, (x, 0, 0), STRAIGHT)))

    def frames(self):
        found = []
        while not isinstance(frame := next(self._frames), Waiting):
            found.append(frame)
        return found

    @property
    def trouble(self):
        return str(self.bus.reported.get("trouble", ""))


def play(live, count=3, **images):
    for stamp_ns in stamps_ns(count):
        live.images(stamp_ns, **images)
    return live.frames()


@pytest.mark.parametrize(
    ("dialect", "distro"), [("jazzy", "jazzy"), ("humble", "humble"), ("bridge", "jazzy")]
)
@pytest.mark.parametrize("asked", ["auto", "own"])
def test_frames_of_every_dialect(dialect, distro, asked):
    live = Live(dialect, dialect="auto" if asked == "auto" else dialect, distro=distro)
    live.infos()
    frames = play(live)
    assert [f.stamp_ns for f in frames] == list(stamps_ns(3))
    assert np.diff([f.seq for f in frames]).tolist() == [1, 1]
    assert frames[0].read_rgb().tolist() == np.full((12, 16, 3), 9).tolist()
    assert (frames[0].read_depth_mm() == 1500).all()
    assert frames[0].T_world_camera is None
    assert live.source.color_camera.size == live.source.depth_camera.size == SIZE
    assert live.source.color_camera.K.tolist() == K.tolist()
    assert not live.trouble
    assert not live.bus.counters


def Live_with_tf(**params):  # noqa: N802
    return Live(pose={"kind": "tf", "world_frame": "map"}, **params)


def test_poses_from_tf_are_interpolated():
    live = Live_with_tf()
    live.infos()
    live.moved(START_NS, 0.0, "map", "base")
    live.send("/tf_static", live.robot.tf((0, "base", "cam", (0, 0, 1), STRAIGHT)))
    live.images(START_NS + NS // 4)
    assert live.frames() == []
    live.moved(START_NS + NS, 4.0, "map", "base")
    (frame,) = live.frames()
    assert frame.T_world_camera[:3, 3].tolist() == [1, 0, 1]
    assert live.source.has_poses
    assert not live.trouble


def test_static_transforms_may_come_after_the_images():
    live = Live_with_tf()
    live.infos()
    live.moved(START_NS, 0.0, "map", "base")
    live.moved(START_NS + NS, 1.0, "map", "base")
    live.images(START_NS + NS // 2)
    assert live.frames() == []
    live.send("/tf_static", live.robot.tf((0, "base", "cam", (0, 0, 1), STRAIGHT)))
    assert live.frames()[0].T_world_camera[:3, 3].tolist() == [0.5, 0, 1]
    assert live.bus.foreign.listening["7/tf_static/*/*"][1]  # what was said before is asked for


def test_poses_on_an_odometry_topic():
    topic = {"kind": "topic", "topic": "/odom"}
    live = Live(pose=topic)
    live.infos()
    live.send("/tf_static", live.robot.tf((0, "base", "cam", (0, 0, 1), STRAIGHT)))
    # tf tells the same pose under another parent: the topic counts.
    live.send("/tf", live.robot.tf((START_NS, "odom", "base", (9, 9, 9), STRAIGHT)))
    for ns, x in ((START_NS, 0.0), (START_NS + NS, 2.0)):
        live.send("/odom", live.robot.odometry((x, 0, 0), STRAIGHT, ns))
    live.images(START_NS + NS // 2)
    assert live.frames()[0].T_world_camera[:3, 3].tolist() == [1, 0, 1]


def test_poses_of_the_camera_on_a_topic():
    topic = {"kind": "topic", "topic": "/pose", "type": "geometry_msgs/msg/PoseStamped"}
    live = Live(pose=topic)
    live.infos()
    live.images(START_NS)
    assert live.frames() == []
    live.send("/pose", live.robot.pose((3, 0, 0), STRAIGHT, START_NS))
    (frame,) = live.frames()
    assert frame.T_world_camera[:3, 3].tolist() == [3, 0, 0]


def test_distortion_is_undone_in_colour_and_depth():
    live = Live()
    d = (-0.4, 0.1, 0.0, 0.0, 0.0)
    wide = np.array([[12.0, 0, 7.5], [0, 12.0, 5.5], [0, 0, 1]])
    live.send("/cam/color/camera_info", live.robot.info(wide, SIZE, "plumb_bob", d, frame="cam"))
    ramp = (np.arange(12)[:, None] * 16 + np.arange(16) + 1).astype(np.uint16)
    live.send(COLOUR, live.robot.image(np.zeros((12, 16, 3), np.uint8), "rgb8", START_NS, "cam"))
    live.send(DEPTH, live.robot.image(ramp, "16UC1", START_NS, "cam"))
    (frame,) = live.frames()
    depth_mm = frame.read_depth_mm()
    # x = 6.5 / 12 from the centre is drawn inwards by 1 - 0.4 r^2 + 0.1 r^4.
    x = 6.5 / 12
    grown = 1 - 0.4 * (x * x + (0.5 / 12) ** 2) + 0.1 * (x * x + (0.5 / 12) ** 2) ** 2
    column = round(7.5 + 12 * x * grown)
    assert depth_mm[6, 14] == ramp[6, column]
    assert column == 13


def test_depth_in_another_frame_is_placed_by_tf():
    live = Live_with_tf()
    live.infos(depth_frame="ir")
    live.send(
        "/tf_static",
        live.robot.tf(
            (0, "link", "cam", (0.05, 0, 0), STRAIGHT), (0, "link", "ir", (0, 0, 0), STRAIGHT)
        ),
    )
    for ns in (START_NS, START_NS + NS):
        live.moved(ns, 0.0, "map", "link")
    live.images(START_NS, depth_frame="ir")
    (frame,) = live.frames()
    assert live.source.T_color_depth[:3, 3].tolist() == [-0.05, 0, 0]
    colour = frame.T_world_camera @ inverse(live.source.T_color_depth)
    assert colour[:3, 3].tolist() == [0.05, 0, 0]


def test_unregistered_depth_without_tf_is_said():
    live = Live()
    live.infos(depth_frame="ir")
    assert play(live, 20, depth_frame="ir") == []
    assert "unregistered_depth: depth is in frame 'ir', colour in 'cam'" in live.trouble
    assert "depth_registered: yes" in live.trouble
    assert live.bus.counters["ros_unregistered_depth"] > 0
    live.send("/tf_static", live.robot.tf((0, "cam", "ir", (0.1, 0, 0), STRAIGHT)))
    assert live.frames()
    assert not live.trouble


def test_depth_that_the_user_says_is_registered():
    live = Live(depth_registered="yes")
    live.infos(depth_frame="ir")
    assert len(play(live, depth_frame="ir")) == 3
    assert (live.source.T_color_depth == np.eye(4)).all()


def test_a_missing_camera_info_is_said_and_mended():
    live = Live()
    assert play(live, 20) == []
    assert "no usable CameraInfo on /cam/color/camera_info" in live.trouble
    live.infos()
    assert live.frames()
    assert "CameraInfo" not in live.trouble


def test_topics_on_which_nothing_comes_are_named():
    live = Live(pose={"kind": "topic", "topic": "/odom"})
    live.frames()
    assert not live.trouble
    live.now_s = 6.0
    live.frames()
    for name in (COLOUR, DEPTH, "/cam/color/camera_info", "/odom"):
        assert f"nothing on {name} for 6 s (ROS_DOMAIN_ID 7)" in live.trouble
    assert live.bus.counters["ros_silent_colour"] == 1
    live.infos()
    live.images(START_NS)
    live.frames()
    assert "nothing on /cam/color" not in live.trouble


def test_a_wrong_resolution_is_said():
    live = Live()
    live.infos(size=(32, 24))
    live.send("/cam/depth/camera_info", live.robot.info(K, SIZE, frame="cam"))
    assert play(live) == []
    said = "resolution: colour is 16x12, its camera_info says 32x24"
    assert said in live.trouble
    assert live.bus.counters["ros_resolution"] == 3


def test_a_clock_that_jumps_is_said_and_followed():
    live = Live_with_tf()
    live.infos()
    for start_ns in (START_NS, START_NS - 1000 * NS, START_NS + 5000 * NS):
        live.moved(start_ns, 0.0)
        live.moved(start_ns + NS, 1.0)
        live.images(start_ns + NS // 2)
        assert len(live.frames()) == 1
    assert live.bus.counters["ros_clock_back"] == 1
    assert live.bus.counters["ros_clock_ahead"] == 2  # colour's and depth's


def test_images_of_two_clocks_are_said():
    live = Live()
    live.infos()
    assert play(live, 40, apart_ns=-40_000_000) == []
    assert "no depth within 0.02 s of colour, the nearest is 0.04 s away" in live.trouble
    assert live.bus.counters["ros_colour_alone"] >= 24
    assert len(Live.frames(live)) == 0
    assert len(play(Live_ready(sync_tolerance_s=0.05), 5, apart_ns=-40_000_000)) == 4


def Live_ready(**params):  # noqa: N802
    live = Live(**params)
    live.infos()
    return live


def test_a_pose_that_does_not_come_is_said():
    live = Live_with_tf()
    live.infos()
    assert play(live, 30) == []
    assert "no_pose: unknown frame 'cam' (known: none)" in live.trouble
    assert live.bus.counters["ros_no_pose"] > 5


def test_another_version_of_a_message_is_said():
    live = Live()
    key = live.robot.key(COLOUR, IMAGE)[:-64] + "0" * 64
    live.bus.foreign.arrive(key, b"anything")
    live.frames()
    assert f"{COLOUR} carries {IMAGE} with hash RIHS01_0000" in live.trouble
    live.bus.foreign.arrive(live.robot.key(COLOUR, "sensor_msgs/msg/LaserScan"), b"anything")
    live.frames()
    assert f"{COLOUR} carries sensor_msgs/msg/LaserScan, expected {IMAGE}" in live.trouble


def test_bytes_that_do_not_decode_are_counted():
    live = Live()
    live.bus.foreign.arrive(live.robot.key(COLOUR, IMAGE), b"\0\1\0\0rubbish")
    live.bus.foreign.arrive(f"7{COLOUR}/Image/RIHS01_00", b"")
    assert live.frames() == []
    assert live.bus.counters["ros_undecodable"] == 2


def test_an_image_that_does_not_decode_is_skipped():
    live = Live()
    live.infos()
    grey = np.zeros((12, 16), np.uint8)
    live.send(COLOUR, live.robot.image(grey, "bayer_rggb8", START_NS, "cam"))
    live.send(DEPTH, live.robot.image(grey.astype(np.uint16), "16UC1", START_NS, "cam"))
    (frame,) = live.frames()
    assert frame.read_rgb() == Skipped(frame.seq, COLOUR, frame.read_rgb().reason)
    assert "bayer_rggb8" in frame.read_rgb().reason


def test_transforms_that_make_no_tree_are_counted():
    live = Live_with_tf()
    live.moved(START_NS, 0.0, "map", "cam")
    live.moved(START_NS, 0.0, "odom", "cam")
    live.moved(START_NS, 0.0, "cam", "map")
    live.frames()
    assert live.bus.counters["ros_bad_transform"] == 2


def test_what_comes_too_fast_is_dropped_and_counted():
    live = Live()
    live.infos()
    for stamp_ns in stamps_ns(40):
        live.images(stamp_ns)
    assert len(live.frames()) == 32
    assert live.bus.counters["ros_messages_dropped"] == 16


def test_compressed_images_by_the_name_of_the_topic():
    import cv2

    live = Live("bridge", colour_topic=f"{COLOUR}/compressed")
    live.infos()
    data = cv2.imencode(".png", np.full((12, 16, 3), 50, np.uint8))[1].tobytes()
    picture = live.robot.compressed(data, "rgb8; png compressed", START_NS, "cam")
    live.send(f"{COLOUR}/compressed", picture)
    depth = np.full((12, 16), 800, np.uint16)
    live.send(DEPTH, live.robot.image(depth, "16UC1", START_NS, "cam"))
    (frame,) = live.frames()
    assert isinstance(frame, RawFrame)
    assert (frame.read_rgb() == 50).all()


def test_a_robot_cannot_be_told_to_move_mugs():
    with pytest.raises(RefusedError, match="a robot's room cannot"):
        Live().source.control("move", {"thing": "mug"})


@pytest.mark.parametrize(
    ("params", "said"),
    [
        ({"depth_topic": ""}, "depth_topic: say it or points_topic"),
        ({"colour_topic": "/a b"}, "is no topic"),
        ({"dialect": "dds"}, "dialect: expected one of auto, jazzy, humble, bridge"),
        ({"distro": "melodic"}, "distro"),
        ({"domain": 400}, "domain: expected 0 to 232"),
        ({"pose": {"kind": "gps"}}, "kind: expected one of none, tf, topic"),
        ({"pose": {"kind": "topic"}}, "is no topic"),
        ({"sync_tolerance_s": 0.0}, "sync_tolerance_s"),
        ({"depth_registered": "maybe"}, "depth_registered"),
    ],
)
def test_bad_parameters_are_named(params, said):
    spec = {"kind": "ros2", "colour_topic": COLOUR, "depth_topic": DEPTH, **params}
    with pytest.raises(ValueError, match=said):
        build("source", spec)


def test_without_a_network_it_says_so():
    source = build("source", {"kind": "ros2", "colour_topic": COLOUR, "depth_topic": DEPTH})
    with pytest.raises(ValueError, match="run the graph with 'sceneq up'"):
        source.connect(object())
    with pytest.raises(ValueError, match="not known before the first frame"):
        _ = source.color_camera


def lidar_live(pose=None, with_tf=True):
    """A source of a camera and a LiDAR that drive along the street."""
    params = {"depth_topic": "", "points_topic": "/points", **({"pose": pose} if pose else {})}
    live = Live(**params)
    live.send("/cam/color/camera_info", live.robot.info(street.K, street.CAMERA.size, frame="cam"))
    if with_tf:
        T_lidar_camera = inverse(street.T_CAMERA_LIDAR)
        turn = Rotation.from_matrix(T_lidar_camera[:3, :3]).as_quat()
        static = live.robot.tf((0, "lidar", "cam", T_lidar_camera[:3, 3], turn))
        live.send("/tf_static", static)
    return live


def drive(live, count):
    for k, stamp_ns in enumerate(stamps_ns(count)):
        rgb, scan = STREET.picture(k)[0], STREET.scan(k)
        live.send(COLOUR, live.robot.image(rgb, "rgb8", stamp_ns, "cam"))
        columns = {name: scan[:, i] for i, name in enumerate(("x", "y", "z", "intensity"))}
        live.send("/points", live.robot.cloud(columns, stamp_ns, "lidar", pad=4))
    return live.frames()


STREET = street.Street()


def test_a_lidar_gives_depth_and_poses():
    live = lidar_live()
    frames = drive(live, 5)
    assert len(frames) == 5
    assert live.source.has_poses
    expected = STREET.pose(4) @ inverse(street.T_CAMERA_LIDAR)
    assert np.linalg.norm(frames[-1].T_world_camera[:3, 3] - expected[:3, 3]) < 0.15
    depth_m, true_m = frames[-1].read_depth_mm() / 1000, STREET.picture(4)[1]
    seen = (depth_m > 0) & (true_m < 65)
    assert seen.mean() > 0.25
    assert np.median(np.abs(depth_m - true_m)[seen] / true_m[seen]) < 0.01
    assert not live.trouble


def test_a_lidar_with_the_poses_of_the_robot():
    live = lidar_live({"kind": "tf", "world_frame": "map"})
    for stamp_ns in (START_NS, START_NS + NS):
        live.moved(stamp_ns, 3.0, "map", "lidar")
    (frame,) = drive(live, 1)
    expected = inverse(street.T_CAMERA_LIDAR)
    expected[0, 3] += 3
    assert np.allclose(frame.T_world_camera, expected)


def test_a_lidar_without_extrinsics_is_said():
    live = lidar_live({"kind": "none", "wait_s": 0.3}, with_tf=False)
    assert drive(live, 5) == []
    assert "no_extrinsics: points are in frame 'lidar', colour in 'cam'" in live.trouble


def test_a_camera_that_changes_is_said():
    live = Live_ready()
    assert len(play(live)) == 3
    live.infos(size=(32, 24))
    live.frames()
    assert "changed_colour_info: colour_info is another one" in live.trouble
    live.infos()
    live.frames()
    assert not live.trouble


def test_ingest_plays_a_robot_as_it_comes():
    bus = FakeBus(Context("ingest", "room", "r1", "cam"))
    source = {"kind": "ros2", "colour_topic": COLOUR, "depth_topic": DEPTH, "domain": 7}
    source["pose"] = {"kind": "tf", "world_frame": "map"}
    keyframes = {"kind": "every", "every": 2}
    params = IngestParams(source=source, rate_hz=30.0, keyframes=keyframes, wait_for=())
    node = Ingest(params, bus.context)
    node.open(bus)
    node.step(None)
    node.step(None)
    assert (bus.reported["state"], bus.sent(POSE)) == ("playing", [])
    live = Live.__new__(Live)
    live.robot, live.bus = Robot(), bus
    live.infos()
    for k, stamp_ns in enumerate(stamps_ns(5)):
        live.moved(stamp_ns, float(k))
        live.images(stamp_ns)
    for _ in range(6):
        node.step(None)
    assert [pose.T_world_camera[0, 3] for pose in bus.sent(POSE)] == [0, 1, 2, 3, 4]
    frames = bus.sent(FRAME)
    assert [frame.T_world_camera[0, 3] for frame in frames] == [0, 2, 4]
    assert frames[0].K.tolist() == K.tolist()
    assert (bus.reported["state"], bus.reported["trouble"]) == ("playing", "")
    assert "frames_late" not in bus.counters


def test_the_last_frame_of_a_robot_that_falls_silent_comes():
    live = Live()
    live.infos()
    assert len(play(live, 3, apart_ns=-3_000_000)) == 2  # a nearer depth might come for the third
    live.now_s += 0.5
    assert live.frames() == []
    live.now_s += 0.6
    (last,) = live.frames()
    assert last.stamp_ns == list(stamps_ns(3))[-1]
    assert live.frames() == []


def test_behind_access_rules_silence_may_be_a_denial(monkeypatch):
    from sceneq_nodes.ros import source as source_module

    monkeypatch.setattr(source_module, "given_credentials", lambda: "some")
    live = Live()
    live.now_s = 6.0
    live.frames()
    said = "nothing on /cam/color/image_raw for 6 s (ROS_DOMAIN_ID 7); with 'secure' only topics"
    assert said in live.trouble
