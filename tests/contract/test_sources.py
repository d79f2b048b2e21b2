"""What every source keeps to, so that ingest can play any of them."""

from collections.abc import Callable
from dataclasses import FrozenInstanceError
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from sceneq_core.ingest.source import RawFrame, RefusedError, Skipped, Source
from sceneq_core.ingest.transforms import rigid_defect
from sceneq_nodes._backends import build, kinds

from support.bags import write_bag2
from support.data_sets import sens_bytes, write_replica, write_tum
from support.lidar_street import write_kitti
from support.mcap_files import write_mcap
from support.more_data_sets import write_redwood, write_rtabmap
from support.seven_scenes import K, write_folder


def folder(path: Path) -> Source:
    """A recording with a frame that is no good."""
    write_folder(path, [0, 2, 4, 6])
    (path / "frame-000004.depth.png").write_bytes(b"gone")
    return build("source", {"kind": "folder", "path": str(path)})


def scannet(path: Path) -> Source:
    """A container with a frame that has no pose."""
    path.mkdir()
    (path / "scan.sens").write_bytes(sens_bytes(4, lost=2))
    return build("source", {"kind": "scannet", "path": str(path)})


def replica(path: Path) -> Source:
    """A scene with a frame whose depth is gone."""
    write_replica(path, 4)
    (path / "results" / "depth000002.png").write_bytes(b"gone")
    return build("source", {"kind": "replica", "path": str(path)})


def tum(path: Path) -> Source:
    """A sequence whose last frame comes after the last pose."""
    write_tum(path, 4)
    np.savetxt(path / "camera-intrinsics.txt", K)
    poses = (path / "groundtruth.txt").read_text().splitlines()
    (path / "groundtruth.txt").write_text("\n".join(poses[:15]))
    return build("source", {"kind": "tum", "path": str(path)})


def kitti(path: Path) -> Source:
    """A drive with a scan that is cut off."""
    write_kitti(path, 3, poses=True)
    (path / "velodyne" / "000001.bin").write_bytes(b"gone")
    return build("source", {"kind": "kitti", "path": str(path)})


def redwood(path: Path) -> Source:
    """A folder with a depth image that is cut off."""
    write_redwood(path, 4)
    (path / "depth" / "000002.png").write_bytes(b"gone")
    return build("source", {"kind": "redwood", "path": str(path)})


def rtabmap(path: Path) -> Source:
    """A database with a node that the optimised graph left out."""
    return build("source", {"kind": "rtabmap", "path": str(write_rtabmap(path, 4))})


def mcap(path: Path) -> Source:
    """A recording with a keyframe that has no depth."""
    path = path.with_suffix(".mcap")
    write_mcap(path, 4, without_depth=2)
    return build("source", {"kind": "mcap", "path": str(path)})


def rosbag(path: Path) -> Source:
    """A bag; what is not complete in it is no frame."""
    return build("source", {"kind": "rosbag", "path": str(write_bag2(path, 4))})


@cache
def furnished() -> Source:
    """Four frames of a simulated room; it takes seconds to light, so it is shared."""
    spec = {"kind": "sim", "room": "bedroom", "seed": 1, "models": "shapes", "frames": 4}
    return build("source", {**spec, "width": 80, "height": 60})


SOURCES: dict[str, Callable[[Path], Source]] = {
    "folder": folder,
    "scannet": scannet,
    "replica": replica,
    "tum": tum,
    "sim": lambda _: furnished(),
    "kitti": kitti,
    "redwood": redwood,
    "rtabmap": rtabmap,
    "mcap": mcap,
    "rosbag": rosbag,
}
LIVE = {"ros2", "realsense", "oak", "orbbec", "record3d"}
"""Without an end; tests/nodes/test_ros_source.py, tests/unit/test_cameras.py hold them to it."""
NOT_INSTALLED = {"r3d", "azure"}
"""Of optional packages; their own tests hold them to it where these are installed."""
FLAWLESS = {"sim", "rosbag"}
"""Sources of which no frame can be bad."""


@pytest.fixture(params=sorted(SOURCES))
def source(request: pytest.FixtureRequest, tmp_path: Path) -> Source:
    return SOURCES[request.param](tmp_path / "recording")


def test_every_source_is_under_contract() -> None:
    assert set(SOURCES) | LIVE | NOT_INSTALLED == set(kinds("source"))


def test_it_describes_its_cameras(source: Source) -> None:
    assert source.name
    assert rigid_defect(source.T_color_depth) is None
    for camera in (source.color_camera, source.depth_camera):
        assert camera.K.shape == (3, 3)
        assert camera.K.dtype == np.float64
        assert min(camera.K[0, 0], camera.K[1, 1], *camera.size) > 0


def test_seq_and_stamps_grow(source: Source) -> None:
    frames = list(source.frames())
    assert all(type(f.seq) is int for f in frames)
    assert (np.diff([f.seq for f in frames]) > 0).all()
    stamps = [f.stamp_ns for f in frames if isinstance(f, RawFrame)]
    assert all(type(stamp) is int for stamp in stamps)
    assert (np.diff(stamps) > 0).all()


def good_frames(source: Source) -> list[RawFrame]:
    frames = [frame for frame in source.frames() if isinstance(frame, RawFrame)]
    assert frames
    return frames


def test_images_fit_the_cameras(source: Source) -> None:
    for frame in good_frames(source):
        rgb, depth_mm = frame.read_rgb(), frame.read_depth_mm()
        assert not isinstance(rgb, Skipped)
        assert not isinstance(depth_mm, Skipped)
        assert (rgb.dtype, rgb.shape) == (np.uint8, (*source.color_camera.size[::-1], 3))
        assert (depth_mm.dtype, depth_mm.shape) == (np.uint16, source.depth_camera.size[::-1])


def test_poses_are_there_or_not_as_promised(source: Source) -> None:
    for frame in good_frames(source):
        assert (frame.T_world_camera is not None) == source.has_poses
        assert frame.T_world_camera is None or rigid_defect(frame.T_world_camera) is None


def test_bad_frames_come_as_skipped(source: Source, request: pytest.FixtureRequest) -> None:
    if request.node.callspec.params["source"] in FLAWLESS:
        return
    skipped = [f for f in source.frames() if isinstance(f, Skipped)]
    assert skipped
    assert all(s.where and s.reason for s in skipped)


def test_it_can_be_played_twice(source: Source) -> None:
    assert [f.seq for f in source.frames()] == [f.seq for f in source.frames()]


def test_frames_are_immutable(source: Source) -> None:
    with pytest.raises(FrozenInstanceError):
        next(source.frames()).seq = 9


def test_what_it_does_not_let_be_changed_it_refuses_with_a_reason(source: Source) -> None:
    for verb, arguments in (("levitate", {}), ("move", {"thing": "zeppelin", "onto": "desk"})):
        with pytest.raises(RefusedError, match=r".+") as caught:
            source.control(verb, arguments)
        assert caught.value.hint
