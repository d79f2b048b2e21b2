"""Redwood, Record3D, RTAB-Map and 7-Scenes recordings, in files of their exact formats."""

import json
import sqlite3
import sys
import zlib
from pathlib import Path
from types import ModuleType

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from sceneq_core.ingest.source import RawFrame, Skipped
from sceneq_nodes._backends import build
from sceneq_nodes._rvl import decode_rvl
from sceneq_nodes._source_kinds import kind_of, need_kind
from sceneq_nodes.datasets.rtabmap_database import calibration_of

from support import more_data_sets as written
from support.data_sets import units
from support.seven_scenes import SIZE, K, pose, write_folder

TURNED = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""A camera looking along y, with z up, where ARKit has one looking along -z with y up."""


def source(kind: str, path: Path, **params):
    return build("source", {"kind": kind, "path": str(path), **params})


def frames(kind: str, path: Path, **params) -> list:
    return list(source(kind, path, **params).frames())


def assert_is_wall(frame: RawFrame, number: int, atol_mm: int = 0) -> None:
    depth = frame.read_depth_mm()
    assert not isinstance(depth, Skipped), depth
    np.testing.assert_allclose(depth.astype(int), units(number, 1000).astype(int), atol=atol_mm)
    assert float(frame.read_rgb()[..., 0].mean()) == pytest.approx(number, abs=2)


@pytest.fixture
def lzfse(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The package of that name, or one with its interface where it is not installed."""
    try:
        import liblzfse
    except ImportError:
        liblzfse = ModuleType("liblzfse")
        liblzfse.compress, liblzfse.decompress = zlib.compress, zlib.decompress
        monkeypatch.setitem(sys.modules, "liblzfse", liblzfse)
    return liblzfse


def test_redwood_frames_and_poses(tmp_path: Path) -> None:
    path = written.write_redwood(tmp_path / "loft", 4)
    assert kind_of(path) == "redwood"
    third = frames("redwood", path)[3]
    assert_is_wall(third, 3)
    np.testing.assert_allclose(third.T_world_camera, pose(3))
    np.testing.assert_array_equal(source("redwood", path).color_camera.K, K)


def test_redwood_scans_with_stamps_go_together_by_time(tmp_path: Path) -> None:
    path = written.write_redwood(tmp_path / "scan", 1, ("rgb", "depth"))
    for part in ("rgb", "depth"):
        for image in (path / part).iterdir():
            image.unlink()
    for number in range(6):
        cv2.imwrite(f"{path}/rgb/{number + 1:07d}-{33333 * number:012d}.jpg", np.zeros((48, 64, 3)))
        if number != 2:
            name = f"{number + 1:07d}-{33333 * number + 9000:012d}.png"
            cv2.imwrite(f"{path}/depth/{name}", units(number, 1000))
    (path / "trajectory.log").unlink()
    found = frames("redwood", path)
    assert [f.stamp_ns for f in found] == [33_333_000 * n for n in (0, 1, 3, 4, 5)]
    assert [int(f.read_depth_mm()[5, 5]) for f in found] == [2000, 2001, 2003, 2004, 2005]
    assert not source("redwood", path).has_poses


def test_the_first_depth_cameras_of_redwood_need_no_file(tmp_path: Path) -> None:
    path = written.write_redwood(tmp_path / "loft", 1)
    (path / "camera_intrinsic.json").unlink()
    with pytest.raises(ValueError, match=r"camera_intrinsic.json: missing, and 64x48"):
        source("redwood", path)
    cv2.imwrite(f"{path}/color/000000.jpg", np.zeros((480, 640, 3)))
    cv2.imwrite(f"{path}/depth/000000.png", np.zeros((480, 640), np.uint16))
    assert source("redwood", path).depth_camera.K[0].tolist() == [525.0, 0.0, 319.5]


@pytest.mark.parametrize(
    ("file", "text", "said"),
    [
        ("camera_intrinsic.json", '{"width": 64}', "camera_intrinsic.json: 'intrinsic_matrix'"),
        ("camera_intrinsic.json", "[]", "camera_intrinsic.json"),
        ("trajectory.log", "0 0 1\n1 0 0 0\n", "trajectory.log"),
        ("trajectory.log", "0 0 1\nx\n", "trajectory.log: could not convert"),
    ],
)
def test_a_malformed_redwood_file_is_named(file: str, text: str, said: str, tmp_path: Path) -> None:
    path = written.write_redwood(tmp_path / "loft", 2)
    (path / file).write_text(text)
    with pytest.raises(ValueError, match=said):
        source("redwood", path)


def test_record3d_turns_arkit_into_our_axes(tmp_path: Path, lzfse: ModuleType) -> None:
    path = written.write_r3d(tmp_path / "desk.r3d", 4, lzfse.compress)
    assert kind_of(path) == "r3d"
    played = source("r3d", path, min_confidence=0)
    third = list(played.frames())[3]
    assert_is_wall(third, 3)
    expected = TURNED.copy()
    expected[0, 3] = 0.03
    np.testing.assert_allclose(third.T_world_camera, expected)
    assert third.stamp_ns == 50_000_000
    np.testing.assert_allclose(played.depth_camera.K, K)
    assert played.color_camera.size == (2 * SIZE[0], 2 * SIZE[1])


def test_record3d_depth_of_low_confidence_is_none(tmp_path: Path, lzfse: ModuleType) -> None:
    path = written.write_r3d(tmp_path / "desk.r3d", 1, lzfse.compress, confidence=1)
    kept, dropped = (
        frames("r3d", path, min_confidence=least)[0].read_depth_mm() for least in (1, 2)
    )
    assert kept[:-1].any()
    assert not kept[-1].any()
    assert not dropped.any()


def test_record3d_colour_is_shrunk_with_its_camera(tmp_path: Path, lzfse: ModuleType) -> None:
    path = written.write_r3d(tmp_path / "desk.r3d", 1, lzfse.compress)
    played = source("r3d", path, color_side_px=64)
    assert played.color_camera.size == SIZE
    np.testing.assert_allclose(played.color_camera.K, K)
    assert next(played.frames()).read_rgb().shape == (48, 64, 3)


def test_record3d_without_its_package_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written.write_r3d(tmp_path / "desk.r3d", 1, bytes)
    monkeypatch.setitem(sys.modules, "liblzfse", None)
    with pytest.raises(ValueError, match=r"pip install 'sceneq\[record3d\]'"):
        source("r3d", path)


def test_bad_record3d_frames_are_skipped(tmp_path: Path, lzfse: ModuleType) -> None:
    path = written.write_r3d(tmp_path / "desk.r3d", 2, lambda data: b"garbage")
    assert [type(f) for f in frames("r3d", path)] == [Skipped, Skipped]


@pytest.mark.parametrize(
    "depth",
    [written.depth_png, written.depth_float_png, written.depth_rvl],
    ids=lambda f: f.__name__,
)
def test_rtabmap_nodes_with_optimised_poses(tmp_path: Path, depth) -> None:
    path = written.write_rtabmap(tmp_path / "home.db", 4, depth)
    assert kind_of(path) == "rtabmap"
    found = frames("rtabmap", path)
    assert [f.seq for f in found] == [1, 2, 3, 4]
    assert isinstance(found[2], Skipped)
    assert "no pose" in found[2].reason
    assert_is_wall(found[1], 2)
    np.testing.assert_allclose(found[1].T_world_camera, pose(2), atol=1e-6)
    assert found[1].stamp_ns == 1_001_500_000_000


def test_rtabmap_without_optimisation_has_the_poses_of_odometry(tmp_path: Path) -> None:
    path = written.write_rtabmap(tmp_path / "home.db", 2, optimised=False)
    found = frames("rtabmap", path)
    np.testing.assert_allclose(found[0].T_world_camera, pose(101), atol=1e-6)


@pytest.mark.parametrize("count", [4, 5, 8, 6])
def test_rtabmap_lenses_are_undone(tmp_path: Path, count: int) -> None:
    path = written.write_rtabmap(tmp_path / "home.db", 2, distortion=[0.2] + [0.0] * (count - 1))
    rgb = frames("rtabmap", path, use_poses=False)[0].read_rgb()
    assert rgb.shape == (48, 64, 3)
    assert rgb[0, 0].tolist() != rgb[24, 32].tolist() or count == 6


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("UPDATE Data SET calibration = x'00'", "calibration has 1 bytes"),
        ("UPDATE Data SET image = NULL", "no node has colour and depth"),
        ("UPDATE Admin SET opt_poses = x'0102'", "Admin.opt_poses"),
        ("DROP TABLE Node", "no such table: Node"),
    ],
)
def test_what_is_wrong_in_a_database_is_named(tmp_path: Path, change: str, said: str) -> None:
    path = written.write_rtabmap(tmp_path / "home.db", 2)
    with sqlite3.connect(path) as file:
        file.execute(change)
    file.close()
    with pytest.raises(ValueError, match=said):
        source("rtabmap", path)


def test_a_damaged_depth_of_a_node_is_skipped(tmp_path: Path) -> None:
    path = written.write_rtabmap(tmp_path / "home.db", 3, lambda n: written.depth_rvl(n)[:40])
    skipped = frames("rtabmap", path)[0].read_depth_mm()
    assert isinstance(skipped, Skipped)
    assert "RVL is cut off" in skipped.reason


@given(
    arrays(
        np.uint16, st.tuples(st.integers(1, 9), st.integers(1, 9)),
        elements=st.sampled_from([0, 0, 0, 1, 2, 999, 1000, 65535]),
    )
)  # fmt: skip
def test_rvl_comes_back(depth: np.ndarray) -> None:
    size = depth.shape[1], depth.shape[0]
    np.testing.assert_array_equal(decode_rvl(written.rvl(depth), size), depth)


@given(st.binary(max_size=40))
def test_rvl_of_anything_is_an_image_or_a_value_error(data: bytes) -> None:
    try:
        assert decode_rvl(data, (4, 3)).shape == (3, 4)
    except ValueError as error:
        assert "RVL" in str(error)  # noqa: PT017


@given(st.integers(0, 400), st.binary(max_size=8))
def test_a_calibration_of_anything_is_one_or_a_value_error(at: int, other: bytes) -> None:
    data = bytearray(written.calibration_blob([0.0] * 5))
    data[at : at + len(other)] = other
    try:
        assert calibration_of(bytes(data)).T_base_camera.shape == (4, 4)
    except ValueError as error:
        assert "calibration" in str(error)  # noqa: PT017


def test_a_sequence_of_7_scenes_has_the_kinects_cameras(tmp_path: Path) -> None:
    cv2.imwrite(f"{tmp_path}/frame-000000.color.png", np.zeros((480, 640, 3)))
    cv2.imwrite(f"{tmp_path}/frame-000000.depth.png", np.full((480, 640), 1000, np.uint16))
    np.savetxt(f"{tmp_path}/frame-000000.pose.txt", np.eye(4))
    played = source("folder", tmp_path)
    assert (played.depth_camera.K[0, 0], played.color_camera.K[0, 0]) == (585.0, 525.0)
    np.savetxt(tmp_path / "camera-intrinsics.txt", np.diag([500.0, 500.0, 1.0]))
    assert source("folder", tmp_path).color_camera.K[0, 0] == 500.0


def test_what_fits_no_layout_is_told_what_was_looked_for(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("nothing")
    for path in (tmp_path, tmp_path / "notes.txt"):
        with pytest.raises(ValueError, match=r"no frames in a layout that is known") as caught:
            need_kind(path)
        for name in ("frame-000000.color.jpg", ".mcap", ".bag", "TUM", ".r3d", "RTAB-Map", ".mkv"):
            assert name in str(caught.value)
    with pytest.raises(ValueError, match="no such file or folder"):
        need_kind(tmp_path / "nowhere")


def test_a_folder_of_sequences_names_them(tmp_path: Path) -> None:
    write_folder(tmp_path / "seq-01", [0])
    with pytest.raises(ValueError, match=r"seq-01 in it can be played"):
        need_kind(tmp_path)


def test_first_bytes_tell_files_apart(tmp_path: Path) -> None:
    cases = {
        "a.mcap": (b"\x89MCAP0\r\n", "rosbag"),
        "b.bag": (b"#ROSBAG V2.0\n", "rosbag"),
        "c.mkv": (b"\x1aE\xdf\xa3", "azure"),
        "d.db": (b"SQLite format 3\0", None),
        "e.mkv": (b"", None),
    }
    for name, (data, kind) in cases.items():
        (tmp_path / name).write_bytes(data)
        assert kind_of(tmp_path / name) == kind, name
    bag = tmp_path / "bag"
    bag.mkdir()
    (bag / "metadata.yaml").write_text(json.dumps({}))
    assert kind_of(bag) == "rosbag"
