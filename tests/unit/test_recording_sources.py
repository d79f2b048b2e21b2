"""ScanNet, Replica and TUM RGB-D recordings, in files of their exact formats."""

from pathlib import Path

import numpy as np
import pytest

from sceneq_core.ingest.source import RawFrame, Skipped
from sceneq_nodes._backends import build
from sceneq_nodes._source_kinds import kind_of
from sceneq_tools.up_command import source_overrides

from support.data_sets import (
    sens_bytes,
    write_replica,
    write_scannet_frames,
    write_tum,
)
from support.seven_scenes import SIZE, K, depth_mm, pose, write_folder

EXPECTED_DEPTH = np.where(depth_mm(3) == 65535, 0, depth_mm(3))


def source(kind: str, path: Path, **params):
    return build("source", {"kind": kind, "path": str(path), **params})


def sens(path: Path, data: bytes) -> Path:
    path.mkdir()
    (path / f"{path.name}.sens").write_bytes(data)
    return path


def frame(kind: str, path: Path, number: int) -> RawFrame:
    found = next(f for f in source(kind, path).frames() if f.seq == number)
    assert isinstance(found, RawFrame)
    return found


def mean_red(of: RawFrame) -> float:
    rgb = of.read_rgb()
    assert not isinstance(rgb, Skipped)
    return float(rgb[..., 0].mean())


MADE = {
    "scannet": lambda path: sens(path, sens_bytes(6)),
    "replica": lambda path: write_replica(path, 6),
    "tum": lambda path: with_camera(write_tum(path, 6)),
}


def with_camera(path: Path) -> Path:
    np.savetxt(path / "camera-intrinsics.txt", K)
    return path


@pytest.mark.parametrize("kind", sorted(MADE))
def test_a_frame_is_what_was_written(kind: str, tmp_path: Path) -> None:
    third = frame(kind, MADE[kind](tmp_path / "scene0000_00"), 3)
    depth = third.read_depth_mm()
    assert not isinstance(depth, Skipped)
    expected = depth_mm(3) if kind == "scannet" else EXPECTED_DEPTH
    held = expected < 65535
    np.testing.assert_allclose(depth[held].astype(int), expected[held].astype(int), atol=1)
    assert (depth[~held] == 0).all()
    assert mean_red(third) == pytest.approx(3, abs=2)
    np.testing.assert_allclose(third.T_world_camera, pose(3), atol=1e-6)


@pytest.mark.parametrize("kind", sorted(MADE))
def test_the_kind_of_a_recording_is_seen_in_its_files(kind: str, tmp_path: Path) -> None:
    assert kind_of(MADE[kind](tmp_path / "scene0000_00")) == kind
    assert kind_of(write_folder(tmp_path / "plain", [0])) == "folder"
    assert kind_of(tmp_path / "nowhere") is None


def test_a_source_on_the_command_line_brings_its_kind(tmp_path: Path) -> None:
    path = MADE["tum"](tmp_path / "desk")
    given = source_overrides(path, None, None, None, False, False, None)
    values = {override.path: override.value for override in given}
    assert values["source", "kind"] == "tum"
    plain = write_folder(tmp_path / "plain", [0])
    given = source_overrides(plain, None, None, None, False, False, None)
    assert [(override.path, override.value) for override in given] == [
        (("source", "kind"), "folder"),
        (("source", "path"), str(plain)),
    ]


def test_extracted_scannet_frames_are_those_of_the_container(tmp_path: Path) -> None:
    packed = sens(tmp_path / "packed", sens_bytes(4, lost=2))
    extracted = write_scannet_frames(tmp_path / "extracted", 4, lost=2)
    assert kind_of(extracted) == "scannet"
    for number in (0, 1, 3):
        one, other = frame("scannet", packed, number), frame("scannet", extracted, number)
        np.testing.assert_array_equal(one.read_rgb(), other.read_rgb())
        depth = one.read_depth_mm()
        np.testing.assert_array_equal(np.where(depth == 65535, 0, depth), other.read_depth_mm())
        np.testing.assert_allclose(one.T_world_camera, other.T_world_camera, atol=1e-6)


def test_a_pose_that_scannet_lost_makes_a_bad_frame(tmp_path: Path) -> None:
    for path in (
        sens(tmp_path / "packed", sens_bytes(3, lost=1)),
        write_scannet_frames(tmp_path / "extracted", 3, lost=1),
    ):
        frames = list(source("scannet", path).frames())
        assert [type(f) for f in frames] == [RawFrame, Skipped, RawFrame]
        assert "not finite" in frames[1].reason


def test_scannet_colour_is_shrunk_to_the_depth_and_its_camera_with_it(tmp_path: Path) -> None:
    path = sens(tmp_path / "scan", sens_bytes(1))
    small, large = source("scannet", path), source("scannet", path, shrink_color=False)
    assert small.color_camera.size == SIZE
    np.testing.assert_allclose(small.color_camera.K, K)
    assert large.color_camera.size == (2 * SIZE[0], 2 * SIZE[1])
    assert large.color_camera.K[0, 0] == 100.0
    assert next(large.frames()).read_rgb().shape == (2 * SIZE[1], 2 * SIZE[0], 3)


def test_a_container_may_be_named_itself_and_hold_raw_depth(tmp_path: Path) -> None:
    path = tmp_path / "scene0000_00.sens"
    path.write_bytes(sens_bytes(2, packed=0))
    played = source("scannet", path)
    assert played.name == "scene0000_00"
    depth = next(played.frames()).read_depth_mm()
    assert depth[5, 5] == 2000


def test_scannet_stamps_are_those_of_the_container(tmp_path: Path) -> None:
    frames = list(source("scannet", sens(tmp_path / "scan", sens_bytes(3))).frames())
    assert [f.stamp_ns for f in frames] == [0, 33_333_000, 66_666_000]


def test_tum_poses_are_interpolated_and_gaps_are_bad_frames(tmp_path: Path) -> None:
    path = with_camera(write_tum(tmp_path / "desk", 3))
    poses = ["# timestamp tx ty tz qx qy qz qw", "100.19 1 0 0 0 0 0 1", "99.99 0 0 0 0 0 0 1"]
    half = np.sqrt(0.5)
    poses.append(f"100.01 0.2 0.4 0 0 0 {half} {half}")
    (path / "groundtruth.txt").write_text("\n".join(poses))
    first, second, third = source("tum", path).frames()
    np.testing.assert_allclose(first.T_world_camera[:3, 3], [0.1, 0.2, 0], atol=1e-9)
    np.testing.assert_allclose(first.T_world_camera[0, :2], [half, -half], atol=1e-9)
    assert isinstance(second, Skipped)
    assert isinstance(third, Skipped)
    assert "groundtruth.txt" in second.where


def test_tum_without_a_ground_truth_has_no_poses(tmp_path: Path) -> None:
    path = with_camera(write_tum(tmp_path / "desk", 2))
    (path / "groundtruth.txt").unlink()
    assert not source("tum", path).has_poses


def test_tum_takes_the_published_camera_of_its_name(tmp_path: Path) -> None:
    played = source("tum", write_tum(tmp_path / "rgbd_dataset_freiburg3_office", 2))
    assert played.color_camera.K[0, 0] == 535.4


def test_tum_images_without_depth_in_time_are_left_out(tmp_path: Path) -> None:
    path = with_camera(write_tum(tmp_path / "desk", 3))
    lines = (path / "depth.txt").read_text().splitlines()
    (path / "depth.txt").write_text("\n".join([lines[0], lines[1], lines[3]]))
    stamps = [f.stamp_ns for f in source("tum", path).frames()]
    assert stamps == [100_000_000_000, 100_200_000_000]


def broken_sens(tmp_path: Path, data: bytes) -> str:
    path = sens(tmp_path / "scan", data)
    with pytest.raises(ValueError, match=r"scan\.sens") as caught:
        source("scannet", path)
    return str(caught.value)


def test_a_broken_container_names_its_field(tmp_path: Path) -> None:
    whole = sens_bytes(2)
    cases = {
        "version: expected 4, got 3": sens_bytes(1, version=3),
        "depth_compression": sens_bytes(1, packed=2),
        "frame 1: the file is cut off": whole[:-1],
        "intrinsic_color": whole[:40],
        "num_frames: 0": sens_bytes(0),
    }
    for number, (expected, data) in enumerate(cases.items()):
        (tmp_path / str(number)).mkdir()
        assert expected in broken_sens(tmp_path / str(number), data)


def test_depth_that_does_not_decompress_is_a_bad_frame(tmp_path: Path) -> None:
    data = bytearray(sens_bytes(1))
    data[-30:] = bytes(30)
    (only,) = source("scannet", sens(tmp_path / "scan", bytes(data))).frames()
    skipped = only.read_depth_mm()
    assert isinstance(skipped, Skipped)
    assert "depth" in skipped.reason


@pytest.mark.parametrize(
    ("kind", "gone", "said"),
    [
        ("replica", "traj.txt", "traj.txt"),
        ("replica", "../cam_params.json", "cam_params.json"),
        ("tum", "rgb.txt", "rgb.txt"),
        ("tum", "camera-intrinsics.txt", "camera-intrinsics.txt"),
        ("scannet", "intrinsic/intrinsic_color.txt", "intrinsic_color.txt"),
    ],
)
def test_a_missing_file_is_named(kind: str, gone: str, said: str, tmp_path: Path) -> None:
    make = {**MADE, "scannet": lambda path: write_scannet_frames(path, 2)}[kind]
    path = make(tmp_path / "recording")
    (path / gone).unlink()
    with pytest.raises(ValueError, match=said):
        source(kind, path)


@pytest.mark.parametrize(
    ("kind", "file", "text", "said"),
    [
        ("replica", "traj.txt", "1 0 0\n", "traj.txt, line 1: expected 16 numbers, got 3"),
        ("replica", "../cam_params.json", '{"camera": {"w": 64}}', "no field 'h'"),
        ("replica", "../cam_params.json", "{", "cam_params.json: camera"),
        ("tum", "rgb.txt", "a b\n", "rgb.txt, line 1"),
        ("tum", "groundtruth.txt", "1 2 3\n", "line 1: expected 8 numbers, got 3"),
        ("tum", "groundtruth.txt", "1 2 3 4 0 0 0 0\n", "unit quaternions"),
        ("tum", "depth.txt", "# nothing\n", "depth.txt: no images"),
        ("scannet", "intrinsic/extrinsic_color.txt", "2 0 0 0\n" * 4, "extrinsic_color"),
    ],
)
def test_a_malformed_file_is_named_with_its_field(
    kind: str, file: str, text: str, said: str, tmp_path: Path
) -> None:
    make = {**MADE, "scannet": lambda path: write_scannet_frames(path, 2)}[kind]
    path = make(tmp_path / "recording")
    (path / file).write_text(text)
    with pytest.raises(ValueError, match=said):
        source(kind, path)
