"""LiDAR scans as depth and as odometry, on a street whose every beam is exact."""

from functools import cache

import numpy as np
import pytest

from sceneq_core.ingest.ingestor import Ingestor
from sceneq_core.ingest.keyframes import EveryNth, EveryNthParams
from sceneq_core.ingest.lidar_depth import LidarDepthParams, lidar_depth_mm
from sceneq_core.ingest.lidar_odometry import LidarOdometry, LidarOdometryParams
from sceneq_core.ingest.source import Camera, RawFrame, Skipped
from sceneq_core.ingest.transforms import angle_deg, distance_m, inverse
from sceneq_nodes._backends import build
from sceneq_nodes._source_kinds import kind_of

from support.lidar_street import CAMERA, T_CAMERA_LIDAR, Street, write_kitti

COUNT = 9


@cache
def drive():
    return Street()


@pytest.fixture(scope="module")
def sequence(tmp_path_factory):
    folder = tmp_path_factory.mktemp("kitti") / "sequences" / "07"
    write_kitti(folder, COUNT)
    return folder


def depth_of(k, **params):
    scan = drive().scan(k)[:, :3]
    return lidar_depth_mm(scan, T_CAMERA_LIDAR, CAMERA, LidarDepthParams(**params)) / 1000


def test_depth_of_a_scan_is_that_of_the_camera():
    depth_m, (_, true_m) = depth_of(4), drive().picture(4)
    seen = (depth_m > 0) & (true_m < 65)
    error = np.abs(depth_m - true_m)[seen] / true_m[seen]
    assert np.median(error) < 0.01
    assert (error > 0.1).mean() < 0.03
    # Of what is less than 4 degrees up, where the LiDAR ends.
    low = np.arange(120)[:, None] > 62
    assert (depth_m > 0)[low & (true_m < 25)].mean() > 0.9


def test_rings_are_joined_only_over_the_reach():
    sparse, dense = depth_of(0, reach_px=1), depth_of(0)
    assert 0 < (sparse > 0).mean() < 0.75 * (dense > 0).mean()
    assert (dense[sparse > 0] > 0).mean() > 0.95


PLAIN = Camera(np.array([[100.0, 0, 50], [0, 100.0, 50], [0, 0, 1]]), (101, 101))


def at(u, v, z):
    return ((u - 50) / 100 * z, (v - 50) / 100 * z, z)


def image(*points, **params):
    array = np.array([at(*p) for p in points], np.float32)
    return lidar_depth_mm(array, np.eye(4), PLAIN, LidarDepthParams(**params))


def test_a_gap_is_filled_with_the_plane_between():
    # Inverse depth is linear: half way between 2 m and 4 m it is 1 / (3/8) m.
    found = image((50, 40, 2.0), (50, 46, 4.0), max_slope_deg=89.0)
    assert found[43, 50] == 2667
    assert found[39, 50] == found[47, 50] == found[43, 51] == 0


def test_nothing_is_filled_across_an_edge_or_a_wide_gap():
    assert np.count_nonzero(image((50, 40, 2.0), (50, 46, 9.0))) == 2
    assert np.count_nonzero(image((50, 40, 2.0), (50, 50, 2.0), reach_px=8)) == 2
    assert np.count_nonzero(image((50, 40, 2.0), (50, 49, 2.0), reach_px=8)) == 10


def test_what_the_camera_cannot_see_is_left_out():
    found = image((50, 50, 8.0), (47, 50, 2.0), (53, 50, 2.0))
    assert found[50, 50] == 2000
    beside = image((50, 50, 8.0), (47, 50, 2.0))
    assert beside[50, 50] == 8000


def test_the_nearest_wins_and_what_is_behind_or_too_far_is_nothing():
    found = image((50, 50, 3.0), (50, 50, 2.0), (20, 20, 70.0))
    assert (found[50, 50], np.count_nonzero(found)) == (2000, 1)
    behind = lidar_depth_mm(np.array([[0, 0, -2.0]], np.float32), np.eye(4), PLAIN)
    assert not behind.any()
    assert not lidar_depth_mm(np.zeros((0, 3), np.float32), np.eye(4), PLAIN).any()


def test_odometry_follows_the_drive():
    odometry = LidarOdometry(LidarOdometryParams())
    for k in range(COUNT):
        found = odometry.register(drive().scan(k)[:, :3])
    assert distance_m(found, drive().pose(COUNT - 1)) < 0.15
    assert angle_deg(found, drive().pose(COUNT - 1)) < 0.5
    assert distance_m(np.eye(4), drive().pose(COUNT - 1)) > 2.5
    assert odometry.register(np.zeros((10, 3), np.float32)) is None


@pytest.mark.parametrize(
    ("name", "value"),
    [("voxel_m", 0.0), ("min_points", 2), ("max_range_m", 0.4), ("min_range_m", -1.0)],
)
def test_bad_parameters_are_named(name, value):
    with pytest.raises(ValueError, match=name):
        LidarOdometryParams(**{name: value})


def source(folder, **params):
    return build("source", {"kind": "kitti", "path": str(folder), **params})


def test_a_sequence_becomes_posed_keyframes(sequence):
    assert kind_of(sequence) == "kitti"
    kitti = source(sequence)
    assert (kitti.name, len(kitti)) == ("07", COUNT)
    assert kitti.color_camera.size == CAMERA.size
    ingestor = Ingestor(kitti, EveryNth(EveryNthParams(every=4)))
    done = [ingestor.ingest(raw) for raw in kitti.frames()]
    assert [d.keyframe is not None for d in done] == [k % 4 == 0 for k in range(COUNT)]
    T_lidar_camera = inverse(T_CAMERA_LIDAR)
    for k in (0, 4, 8):
        expected = drive().pose(k) @ T_lidar_camera
        assert distance_m(done[k].T_world_camera, expected) < 0.15
    depth_m = done[8].keyframe.depth_m
    assert (depth_m > 0).mean() > 0.3
    assert done[8].keyframe.rgb.tolist() == drive().picture(8)[0].tolist()
    assert [d.stamp_ns for d in done] == [k * 100_000_000 for k in range(COUNT)]


def test_given_poses_are_those_of_camera_0(tmp_path):
    folder = tmp_path / "00"
    write_kitti(folder, 3, poses=True)
    first, *_, last = source(folder).frames()
    moved = inverse(first.T_world_camera) @ last.T_world_camera
    expected = T_CAMERA_LIDAR @ inverse(drive().pose(0)) @ drive().pose(2) @ inverse(T_CAMERA_LIDAR)
    assert np.allclose(moved, expected, atol=1e-5)
    estimated = list(source(folder, use_poses=False).frames())
    assert np.allclose(estimated[0].T_world_camera, inverse(T_CAMERA_LIDAR), atol=1e-6)


def test_poses_where_kitti_keeps_them(tmp_path):
    folder = tmp_path / "sequences" / "03"
    write_kitti(folder, 2, poses=True)
    (tmp_path / "poses").mkdir()
    (folder / "poses.txt").rename(tmp_path / "poses" / "03.txt")
    assert isinstance(next(source(folder).frames()), RawFrame)
    assert np.allclose(next(source(folder).frames()).T_world_camera[0, 3], -0.06)


def test_files_that_are_no_good(tmp_path):
    folder = tmp_path / "01"
    write_kitti(folder, 3)
    scan, picture = folder / "velodyne" / "000001.bin", folder / "image_2" / "000002.png"
    scan.write_bytes(scan.read_bytes()[:-3])
    picture.write_bytes(picture.read_bytes()[:100])
    _, cut, last = source(folder).frames()
    assert isinstance(cut, Skipped)
    assert cut.where == str(scan)
    assert "no points of 4 floats" in cut.reason
    assert "cut off" in last.read_rgb().reason


@pytest.mark.parametrize(
    ("file", "text", "said"),
    [
        ("calib.txt", "P2: 1 2 3\n", "no line 'P2:' with 12 numbers"),
        ("calib.txt", "P2: a b c\n", "P2: not numbers"),
        ("times.txt", "0.0\n0.0\n", "expected 2 growing times"),
        ("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n", "1 poses for 2 frames"),
    ],
)
def test_a_sequence_that_cannot_be_played(tmp_path, file, text, said):
    folder = tmp_path / "02"
    write_kitti(folder, 2)
    (folder / file).write_text(text)
    with pytest.raises(ValueError, match=said):
        source(folder)
