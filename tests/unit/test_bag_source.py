"""Bags of ROS 1 and ROS 2, written by ``rosbags``, as a source."""

from pathlib import Path

import numpy as np
import pytest

from sceneq_core.ingest.source import RawFrame
from sceneq_nodes._backends import build
from sceneq_nodes._source_kinds import kind_of
from sceneq_nodes.recording.bag_topics import Names, camera_topics
from sceneq_nodes.ros.reader import CAMERA_INFO, COMPRESSED, IMAGE

from support.bags import COLOUR, DEPTH, START_NS, STEP_NS, write_bag1, write_bag2
from support.data_sets import units
from support.seven_scenes import K, color, pose


def source(path: Path, **params):
    return build("source", {"kind": "rosbag", "path": str(path), **params})


def write(form: str, tmp_path: Path, **options) -> Path:
    if form == "bag":
        return write_bag1(tmp_path / "run.bag", 5, **options)
    bag = write_bag2(tmp_path / "run", 5, mcap="mcap" in form, **options)
    return next(bag.glob(f"*.{form}")) if form in ("mcap", "db3") else bag


@pytest.mark.parametrize("form", ["bag", "folder", "db3", "mcap", "mcap folder"])
def test_a_bag_is_played_as_it_was(form: str, tmp_path: Path) -> None:
    path = write(form, tmp_path)
    assert kind_of(path) == "rosbag"
    played = source(path)
    np.testing.assert_array_equal(played.color_camera.K, K)
    frames = list(played.frames())
    assert [f.seq for f in frames] == [0, 1, 2, 3, 4]
    for number, frame in enumerate(frames):
        assert isinstance(frame, RawFrame)
        assert frame.stamp_ns == START_NS + STEP_NS * number
        np.testing.assert_array_equal(frame.read_rgb(), color(number))
        np.testing.assert_array_equal(frame.read_depth_mm(), units(number, 1000))
        np.testing.assert_allclose(frame.T_world_camera, pose(number))


def test_packed_colour_and_a_topic_of_poses(tmp_path: Path) -> None:
    frames = list(source(write("folder", tmp_path, poses="topic", packed=True)).frames())
    assert len(frames) == 5
    assert float(frames[3].read_rgb()[..., 0].mean()) == pytest.approx(3, abs=2)
    np.testing.assert_allclose(frames[3].T_world_camera, pose(3))


def test_a_bag_without_poses_says_so(tmp_path: Path) -> None:
    path = write("bag", tmp_path, poses="none")
    assert not source(path).has_poses
    assert next(iter(source(path).frames())).T_world_camera is None
    assert not source(write("folder", tmp_path), use_poses=False).has_poses


@pytest.mark.parametrize("late_ns", [-5_000_000, 5_000_000])
def test_the_last_frame_is_played_whichever_image_is_first(late_ns: int, tmp_path: Path) -> None:
    path = write("folder", tmp_path, poses="none", late_ns=late_ns)
    assert [int(f.read_rgb()[0, 0, 0]) for f in source(path).frames()] == [0, 1, 2, 3, 4]


def test_images_that_wait_for_a_pose_at_the_end_are_counted(tmp_path: Path) -> None:
    played = source(write("folder", tmp_path, late_ns=5_000_000))
    assert len(list(played.frames())) == 4  # nobody says where the camera was after the last tf
    assert played._troubles.counts["no_pose"] == 1


def test_seek_step_and_loop(tmp_path: Path) -> None:
    path = write("folder", tmp_path)
    late = [f.stamp_ns for f in source(path, start_s=0.25).frames()]
    assert late == [START_NS + STEP_NS * n for n in (3, 4)]
    assert [f.seq for f in source(path, step=2).frames()] == [0, 2, 4]
    looped = source(path, loop=True).frames()
    stamps = [next(looped).stamp_ns for _ in range(7)]
    assert stamps == [START_NS + STEP_NS * n for n in range(7)]


def test_what_is_not_there_is_named(tmp_path: Path) -> None:
    path = write("folder", tmp_path)
    with pytest.raises(ValueError, match=rf"no topic /eye; there are .*{COLOUR}"):
        source(path, colour_topic="/eye")
    with pytest.raises(
        ValueError, match=r"camera_info_topic: no topic /nowhere.*there are: /camera"
    ):
        source(path, camera_info_topic="/nowhere/camera_info")
    (tmp_path / "broken.bag").write_bytes(b"#ROSBAG V2.0\nrubbish")
    with pytest.raises(ValueError, match=r"broken\.bag"):
        source(tmp_path / "broken.bag")


def test_of_many_topics_the_calibrated_and_aligned_ones_are_taken() -> None:
    nothing = Names("", "", "", "")
    types = {
        COLOUR: IMAGE,
        f"{COLOUR}/compressed": COMPRESSED,
        "/camera/color/camera_info": CAMERA_INFO,
        DEPTH: IMAGE,
        "/camera/depth/image_rect_raw": IMAGE,
        "/camera/aligned_depth_to_color/camera_info": CAMERA_INFO,
        "/camera/depth/camera_info": CAMERA_INFO,
        "/camera/infra1/image_rect_raw": IMAGE,
    }
    found = camera_topics(nothing, types)
    assert (found.colour, found.depth) == (COLOUR, DEPTH)
    assert found.colour_info == "/camera/color/camera_info"
    two = {"/a/rgb/image_raw": IMAGE, "/b/rgb/image_raw": IMAGE, "/a/depth/image_raw": IMAGE}
    with pytest.raises(ValueError, match=r"colour_topic: several .*/a/rgb.*, /b/rgb.*say which"):
        camera_topics(nothing, two)
    with pytest.raises(ValueError, match=r"depth_topic: no topic looks like it: /a/rgb"):
        camera_topics(nothing, {"/a/rgb/image_raw": IMAGE})
