"""The map as ROS messages, decoded with ``rosbags`` as a ROS program would."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sceneq_nodes._bus import Context
from sceneq_nodes._convert import map_delta_message
from sceneq_nodes._params import validate
from sceneq_nodes.ros.keys import unpack_attachment
from sceneq_nodes.ros.output import RosOutput, RosOutputParams
from sceneq_nodes.ros.point_cloud import cloud_columns
from sceneq_nodes.ros.typestore import typestore
from sceneq_schemas.label import InstanceLabel, LabelDelta
from sceneq_schemas.topics import LABEL_DELTA, MAP_DELTA

from support.fake_bus import FakeBus
from support.true_map import delta, instance, voxels

STORE = typestore("jazzy")
S = 1_000_000_000
BOX = np.eye(4)
BOX[:3, :3] = Rotation.from_euler("z", 90, degrees=True).as_matrix()
BOX[:3, 3] = (1, 2, 3)
MUG = instance(
    7,
    [1],
    T_world_box=BOX,
    box_size_m=np.array([0.1, 0.2, 0.3]),
    aabb_world=np.array([[0.9, 1.95, 2.85], [1.1, 2.05, 3.15]]),
)
WALL = instance(8, [2], role="wall")
GUESS = instance(9, [3], state="tentative")
MAP = delta(stamp_ns=5 * S + 3, instances=(MUG, WALL, GUESS), **voxels([0, 1, 2], [1, 1, 2]))


class Output:
    """The node on a fake network."""

    def __init__(self, **params):
        self.now_s = 100.0
        self.bus = FakeBus(Context("ros", "room", "r1", "cam"))
        given = validate(RosOutputParams, {"domain": 7, **params})
        self.node = RosOutput(given, self.bus.context, clock=lambda: self.now_s)
        self.node.open(self.bus)

    def map(self, change=MAP, seq=1):
        self.bus.deliver(self.node, MAP_DELTA, map_delta_message(change, 1, seq))

    def names(self, *labels, seq=1, removed=()):
        self.bus.deliver(
            self.node,
            LABEL_DELTA,
            LabelDelta(1, seq, False, 0, 0, "hash", "set", 1, labels, np.array(removed, np.int32)),
        )

    def sent(self, name):
        """All messages on ``/scene_q/<name>``, decoded."""
        found = []
        for sample in self.bus.foreign.published:
            if f"scene_q/{name}" in sample.key:
                kind = {
                    "detections": "vision_msgs/msg/Detection3DArray",
                    "markers": "visualization_msgs/msg/MarkerArray",
                    "cloud": "sensor_msgs/msg/PointCloud2",
                }[name]
                found.append(STORE.decode(kind, sample.payload))
        return found


def named(instance_id, name, p, accepted=True):
    return InstanceLabel(instance_id, name, p, accepted, "encoder")


def test_detections_have_box_id_and_name():
    output = Output()
    output.names(named(7, "mug", 0.75), named(8, "wall", 0.9))
    output.map()
    (message,) = output.sent("detections")
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (5, 3)
    assert message.header.frame_id == "map"
    (mug,) = message.detections
    box = mug.bbox
    assert (mug.id, box.size.x, box.size.y, box.size.z) == ("7", 0.1, 0.2, 0.3)
    assert (box.center.position.x, box.center.position.z) == (1, 3)
    turned = box.center.orientation
    assert np.allclose((turned.x, turned.y, turned.z, turned.w), (0, 0, 0.5**0.5, 0.5**0.5))
    (result,) = mug.results
    assert (result.hypothesis.class_id, result.hypothesis.score) == ("mug", 0.75)
    assert result.pose.pose.position.y == 2


def test_a_name_that_is_not_sure_is_none():
    output = Output()
    output.names(named(7, "mug", 0.3, accepted=False))
    output.map()
    assert output.sent("detections")[0].detections[0].results == []
    texts = [m.text for m in output.sent("markers")[0].markers if m.text]
    assert texts == ["7"]


def test_markers_replace_all_earlier_ones():
    output = Output()
    output.names(named(7, "mug", 0.75))
    output.map()
    (message,) = output.sent("markers")
    clear, box, name = message.markers
    assert clear.action == clear.DELETEALL == 3
    assert (box.ns, box.id, box.type, box.action) == ("boxes", 7, box.CUBE, box.ADD)
    assert (name.ns, name.type, name.text) == ("names", name.TEXT_VIEW_FACING, "7 mug")
    assert name.pose.position.z == pytest.approx(3 + 0.15 + 0.12)
    assert 0 < box.color.a < 1


def test_the_cloud_says_the_instance_of_every_point():
    output = Output()
    output.map()
    (message,) = output.sent("cloud")
    columns = cloud_columns(message)
    assert list(columns) == ["x", "y", "z", "rgb", "instance_id"]
    assert columns["instance_id"].tolist() == [7, 7, 8]
    assert columns["instance_id"].dtype == np.uint32
    assert np.allclose(columns["x"], [0.015, 0.045, 0.075])
    assert columns["rgb"].view(np.uint32).tolist() == [0x5A5A5A] * 3
    assert message.header.frame_id == "map"


def test_a_large_cloud_is_thinned():
    output = Output(max_points=2)
    output.map()
    assert output.sent("cloud")[0].width == 2


def test_it_publishes_no_more_often_than_told_and_repeats():
    output = Output(rate_hz=2.0, repeat_s=5.0)
    output.map()
    output.map(delta(frame_seq=1, stamp_ns=6 * S), seq=2)
    assert len(output.sent("detections")) == 1
    output.now_s += 0.5
    output.node.step(None)
    assert [m.header.stamp.sec for m in output.sent("detections")] == [5, 6]
    for wait_s, count in ((4.9, 2), (0.2, 3)):
        output.now_s += wait_s
        output.node.step(None)
        assert len(output.sent("detections")) == count


def test_nothing_is_said_of_a_map_that_is_not_there():
    output = Output()
    output.node.step(None)
    output.names(named(7, "mug", 0.75))
    assert not output.bus.foreign.published


def test_keys_tokens_and_attachments_of_rmw_zenoh():
    output = Output()
    output.map()
    keys = [sample.key for sample in output.bus.foreign.published]
    kind = "vision_msgs/msg/Detection3DArray"
    assert keys[0] == (
        f"7/scene_q/detections/vision_msgs::msg::dds_::Detection3DArray_/{STORE.hash(kind)}"
    )
    attached = [unpack_attachment(s.attachment) for s in output.bus.foreign.published]
    assert [a.seq for a in attached] == [1, 1, 1]
    assert len({a.gid for a in attached}) == 3
    zid = output.bus.foreign.session_id
    assert f"@ros2_lv/7/{zid}/0/0/NN/%/%/sceneq" in output.bus.foreign.held
    publishers = [token for token in output.bus.foreign.held if "/MP/" in token]
    assert [token.split("/")[9] for token in publishers] == [
        "%scene_q%detections",
        "%scene_q%markers",
        "%scene_q%cloud",
    ]


def test_keys_of_humble_and_of_the_bridge():
    humble = Output(dialect="humble", distro="humble")
    humble.map()
    assert all(s.key.endswith("/TypeHashNotSupported") for s in humble.bus.foreign.published)
    bridge = Output(dialect="bridge")
    bridge.map()
    assert bridge.bus.foreign.published[0].key == "scene_q/detections"
    assert not bridge.bus.foreign.held
    assert not any(s.attachment for s in bridge.bus.foreign.published)


def test_a_delta_that_fits_no_map_is_counted():
    output = Output()
    output.map(replace(MAP, removed_voxel_id=np.array([99], np.int32)))
    assert output.bus.counters["map_delta_bad"] == 1


@pytest.mark.parametrize(
    ("params", "said"),
    [
        ({"prefix": "a b"}, "is no topic"),
        ({"dialect": "auto"}, "dialect: expected one of jazzy, humble, bridge"),
        ({"rate_hz": 0.0}, "rate_hz"),
        ({"domain": -1}, "domain"),
        ({"max_points": 0}, "max_points"),
    ],
)
def test_bad_parameters_are_named(params, said):
    with pytest.raises(ValueError, match=said):
        RosOutputParams(**params)
