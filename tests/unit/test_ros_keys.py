"""Keys, attachments, tokens, type hashes and clouds: byte by byte as others have them."""

import struct

import numpy as np
import pytest

from sceneq_nodes.ros.keys import (
    Attachment,
    DataKey,
    data_key,
    node_token,
    pack_attachment,
    parse_key,
    publisher_token,
    selectors,
    topic_path,
    unpack_attachment,
)
from sceneq_nodes.ros.point_cloud import cloud_columns, cloud_fields, cloud_xyz, packed_rgb
from sceneq_nodes.ros.typestore import DISTROS, WireError, typestore

from support.ros_robot import GID, Robot

ROBOT = Robot()
IMAGE_HASH = "RIHS01_d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47"
PUBLISHED = {
    "std_msgs/msg/String": "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
    "sensor_msgs/msg/Image": IMAGE_HASH.removeprefix("RIHS01_"),
    "vision_msgs/msg/Detection3DArray": (
        "793f5eab9595ac1c0da07873cc859db42eae51f0ee76056db8562515d830e018"
    ),
}
"""As the documentation of rmw_zenoh, and other programs that talk to it, have them."""


@pytest.mark.parametrize("distro", DISTROS)
def test_hashes_are_the_published_ones(distro):
    store = typestore(distro)
    assert {name: store.hash(name) for name in PUBLISHED} == {
        name: f"RIHS01_{digits}" for name, digits in PUBLISHED.items()
    }
    with pytest.raises(ValueError, match="expected one of humble, jazzy"):
        typestore("melodic")


KEYS = {
    "jazzy": f"7/camera/color/image_raw/sensor_msgs::msg::dds_::Image_/{IMAGE_HASH}",
    "humble": "7/camera/color/image_raw/sensor_msgs::msg::dds_::Image_/TypeHashNotSupported",
    "bridge": "camera/color/image_raw",
}
TOPIC = "/camera/color/image_raw"


@pytest.mark.parametrize("dialect", KEYS)
def test_keys_of_every_dialect(dialect):
    type_hash = {"jazzy": IMAGE_HASH, "humble": "TypeHashNotSupported"}.get(dialect, "")
    key = KEYS[dialect]
    assert data_key(TOPIC, "sensor_msgs/msg/Image", type_hash, 7, dialect) == key
    named = "" if dialect == "bridge" else "sensor_msgs/msg/Image"
    assert parse_key(key, TOPIC) == DataKey(TOPIC, named, type_hash)


def test_selectors():
    rmw, bridge = "7/camera/color/image_raw/*/*", "camera/color/image_raw"
    assert selectors(TOPIC, 7, "jazzy") == selectors(TOPIC, 7, "humble") == [rmw]
    assert selectors(TOPIC, 7, "bridge") == [bridge]
    assert selectors(TOPIC, 7, "auto") == [rmw, bridge]


def test_a_key_with_something_else_is_refused():
    with pytest.raises(WireError, match="is no type"):
        parse_key("7/camera/color/image_raw/Image/RIHS01_00", TOPIC)


@pytest.mark.parametrize("topic", ["", "/", "/a//b", "/a b", "/camera/*", "/a/b/", "1/2", "/a?"])
def test_what_is_no_topic(topic):
    with pytest.raises(ValueError, match="is no topic"):
        topic_path(topic)


def test_the_attachment_is_33_bytes():
    data = pack_attachment(Attachment(5, 1_700_000_000_123_456_789, GID))
    assert data == struct.pack("<qq", 5, 1_700_000_000_123_456_789) + b"\x10" + GID
    assert len(data) == 33
    assert unpack_attachment(data) == Attachment(5, 1_700_000_000_123_456_789, GID)
    with pytest.raises(WireError, match="of 32 bytes"):
        unpack_attachment(data[:-1])
    with pytest.raises(WireError, match="gid of 9 bytes"):
        unpack_attachment(data[:16] + b"\x09" + GID)


def test_tokens_of_a_node_and_its_publisher():
    zid = "0123abcd"
    assert node_token(7, zid, "sceneq") == "@ros2_lv/7/0123abcd/0/0/NN/%/%/sceneq"
    typed = ("visualization_msgs/msg/MarkerArray", "RIHS01_00")
    assert publisher_token(7, zid, 3, "sceneq", "/sceneq/markers", typed) == (
        "@ros2_lv/7/0123abcd/0/3/MP/%/%/sceneq/%sceneq%markers/"
        "visualization_msgs::msg::dds_::MarkerArray_/RIHS01_00/::,10:,:,:,,"
    )


COLUMNS = {
    "x": np.array([1, np.nan, 0, -4], "f4"),
    "y": np.array([2, 5, 0, 5], "f4"),
    "z": np.array([3, 6, 0, 6], "f4"),
    "ring": np.array([7, 8, 9, 1000], "u2"),
    "t": np.array([0.1, 0.2, 0.3, 0.4], "f8"),
}


@pytest.mark.parametrize("pad", [0, 6])
def test_a_cloud_with_any_fields(pad):
    message = ROBOT.cloud(COLUMNS, pad=pad)
    received = typestore("jazzy").decode(message.__msgtype__, ROBOT.data(message))
    columns = cloud_columns(received)
    assert {name: column.dtype for name, column in columns.items()} == {
        name: column.dtype for name, column in COLUMNS.items()
    }
    assert columns["ring"].tolist() == [7, 8, 9, 1000]
    points, measured = cloud_xyz(received)
    assert points.tolist() == [[1, 2, 3], [-4, 5, 6]]
    assert measured.tolist() == [True, False, False, True]


def test_a_cloud_that_is_none():
    message = ROBOT.cloud(COLUMNS)
    with pytest.raises(WireError, match="without x"):
        cloud_xyz(ROBOT.cloud({"y": COLUMNS["y"], "z": COLUMNS["z"]}))
    object.__setattr__(message, "data", message.data[:-1])
    with pytest.raises(WireError, match="4x1 points with only"):
        cloud_xyz(message)
    object.__setattr__(message, "point_step", 10)
    with pytest.raises(WireError, match="point fields"):
        cloud_xyz(message)
    assert cloud_xyz(ROBOT.cloud({name: c[:0] for name, c in COLUMNS.items()}))[0].shape == (0, 3)


def test_a_cloud_goes_out_as_it_would_come_in():
    fields, step, data = cloud_fields(COLUMNS, ROBOT.types["sensor_msgs/msg/PointField"])
    theirs = ROBOT.cloud(COLUMNS)
    assert (step, data.tobytes()) == (theirs.point_step, theirs.data.tobytes())
    assert [(f.name, f.offset, f.datatype) for f in fields] == [
        (f.name, f.offset, f.datatype) for f in theirs.fields
    ]
    rgb = packed_rgb(np.array([[1, 2, 3]], np.uint8))
    assert rgb.view(np.uint32).tolist() == [0x010203]
