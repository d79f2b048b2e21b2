"""A live source in one word of the command line."""

import pytest

from sceneq_nodes._backends import check
from sceneq_tools.errors import UserError
from sceneq_tools.live_source import is_live, live_overrides, ros2_source
from sceneq_tools.up_command import source_overrides

TOPICS = "/cam/color/image_raw,/cam/depth/image_raw"


def test_topics_and_keys():
    spec = ros2_source(f"{TOPICS},domain=7,dialect=bridge,sync=0.05,registered=yes")
    assert spec == {
        "kind": "ros2",
        "colour_topic": "/cam/color/image_raw",
        "depth_topic": "/cam/depth/image_raw",
        "domain": 7,
        "dialect": "bridge",
        "sync_tolerance_s": 0.05,
        "depth_registered": "yes",
    }
    check("source", spec)


@pytest.mark.parametrize(
    ("key", "pose"),
    [
        ("world=odom", {"kind": "tf", "world_frame": "odom"}),
        ("odom=/odom", {"kind": "topic", "topic": "/odom"}),
        (
            "pose=/p",
            {"kind": "topic", "topic": "/p", "type": "geometry_msgs/msg/PoseStamped"},
        ),
    ],
)
def test_poses(key, pose):
    spec = ros2_source(f"{TOPICS},{key}")
    assert spec["pose"] == pose
    check("source", spec)


def test_a_lidar_in_place_of_depth():
    spec = ros2_source("/cam/image_raw,points=/velodyne_points,info=/cam/info")
    assert (spec["points_topic"], spec["camera_info_topic"]) == ("/velodyne_points", "/cam/info")
    check("source", spec)


def test_what_it_puts_over_the_graph():
    found = {o.path: o.value for o in live_overrides(f"ros2:{TOPICS}", None, None)}
    assert found[("scene",)] == "robot"
    assert found[("rate_hz",)] == 30.0
    assert found[("source",)]["kind"] == "ros2"
    named = {o.path: o.value for o in live_overrides(f"ros2:{TOPICS}", "hall", 0.0)}
    assert (named[("scene",)], named[("rate_hz",)]) == ("hall", 0.0)


def test_the_options_of_up():
    source = f"ros2:{TOPICS},world=map"
    overrides = source_overrides(source, None, None, None, False, True, "rgbd")
    found = {o.path: o.value for o in overrides}
    assert "pose" not in found[("source",)]
    assert found[("segmenter",)] == {"kind": "rgbd"}
    for step, loop, said in ((2, False, "--step"), (None, True, "--loop")):
        with pytest.raises(UserError, match=f"{said}: a robot is no recording"):
            source_overrides(source, None, None, step, loop, False, None)


def test_a_path_is_none():
    assert is_live(f"ros2:{TOPICS}")
    assert not is_live("ros2/recording")
    assert not is_live(None)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "expected ros2:COLOUR,DEPTH"),
        ("a,b,c", "expected ros2:COLOUR,DEPTH"),
        (f"{TOPICS},domian=7", "unknown key 'domian' .did you mean 'domain'"),
        (f"{TOPICS},domain=x", "domain=x"),
    ],
)
def test_what_cannot_be_read_is_named(text, said):
    with pytest.raises(UserError, match=said):
        ros2_source(text)
