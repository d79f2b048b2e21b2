"""The folder source: what it reads, and everything that can be wrong with a folder."""

import json
from collections.abc import Callable
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
import pytest

from sceneq_core.ingest.source import RawFrame, Skipped
from sceneq_nodes._folder_source import FolderParams, FolderSource

from support.seven_scenes import SIZE, K, color, depth_mm, pose, write_folder


def opened(folder: Path, **params) -> FolderSource:
    return FolderSource(FolderParams(str(folder), **params))


def frames(folder: Path, **params) -> list[RawFrame | Skipped]:
    return list(opened(folder, **params).frames())


def test_a_frame_has_number_stamp_pose_and_images(tmp_path: Path) -> None:
    source = opened(write_folder(tmp_path / "shelf", [0, 2, 4]))
    assert source.name == "shelf"
    assert source.has_poses
    assert len(source) == 3
    assert source.color_camera == source.depth_camera
    assert source.color_camera.size == SIZE
    np.testing.assert_array_equal(source.depth_camera.K, K)
    np.testing.assert_array_equal(source.T_color_depth, np.eye(4))
    last = list(source.frames())[-1]
    assert isinstance(last, RawFrame)
    assert last.seq == 4
    assert last.stamp_ns == 133_333_333
    np.testing.assert_array_equal(last.T_world_camera, pose(4))
    np.testing.assert_array_equal(last.read_rgb(), color(4))


def test_both_kinds_of_missing_depth_become_zero(tmp_path: Path) -> None:
    (frame,) = frames(write_folder(tmp_path, [7]))
    expected = depth_mm(7)
    expected[0, 1] = 0
    np.testing.assert_array_equal(frame.read_depth_mm(), expected)


def test_step_takes_every_nth_file(tmp_path: Path) -> None:
    folder = write_folder(tmp_path, [0, 2, 4, 6, 8])
    assert [f.seq for f in frames(folder, step=2)] == [0, 4, 8]


def test_a_loop_goes_on_with_seq_and_stamps(tmp_path: Path) -> None:
    source = opened(write_folder(tmp_path, [3, 5, 7]), loop=True)
    lap = list(islice(source.frames(), 7))
    assert [f.seq for f in lap] == [3, 5, 7, 9, 11, 13, 15]
    assert np.diff([f.stamp_ns for f in lap]).min() > 0
    np.testing.assert_array_equal(lap[3].T_world_camera, pose(3))


def test_a_loop_ends_when_the_files_are_gone(tmp_path: Path) -> None:
    frames_ = opened(write_folder(tmp_path, [3, 5]), loop=True).frames()
    assert [type(next(frames_)) for _ in range(3)] == [RawFrame] * 3
    for path in tmp_path.glob("frame-*"):
        path.unlink()
    rest = list(frames_)
    assert [(type(one), one.seq) for one in rest] == [(Skipped, n) for n in (9, 11, 13)]


def test_poses_can_be_left_alone(tmp_path: Path) -> None:
    folder = write_folder(tmp_path, [0])
    assert not opened(folder, use_poses=False).has_poses
    assert frames(folder, use_poses=False)[0].T_world_camera is None


def test_a_folder_without_pose_files_has_no_poses(tmp_path: Path) -> None:
    folder = write_folder(tmp_path, [0, 1], poses=False)
    assert not opened(folder).has_poses
    assert [f.T_world_camera for f in frames(folder)] == [None, None]


@pytest.mark.parametrize(
    ("numbers", "lines", "expected"),
    [
        ([0, 2, 4], [0.0, 0.5, 0.75], [0, 500_000_000, 750_000_000]),  # one line a file
        ([0, 2], [0.0, 0.1, 0.2], [0, 200_000_000]),  # one line a number, a file is gone
    ],
)
def test_stamps_file(tmp_path: Path, numbers, lines, expected) -> None:
    folder = write_folder(tmp_path, numbers)
    np.savetxt(folder / "stamps.txt", lines)
    assert [f.stamp_ns for f in frames(folder)] == expected


def test_two_cameras(tmp_path: Path) -> None:
    T_color_depth = np.eye(4)
    T_color_depth[0, 3] = -0.02
    camera = {"K": (K * [[2], [2], [1]]).tolist(), "T_color_depth": T_color_depth.tolist()}
    folder = write_folder(tmp_path, [0])
    (folder / "camera-color.json").write_text(json.dumps(camera))
    cv2.imwrite(str(folder / "frame-000000.color.png"), np.zeros((96, 128, 3), np.uint8))
    source = opened(folder)
    assert source.color_camera.size == (128, 96)
    assert source.color_camera.K[0, 0] == 100
    np.testing.assert_array_equal(source.T_color_depth, T_color_depth)


def cut(name: str, keep: float) -> Callable[[Path], None]:
    def damage(folder: Path) -> None:
        data = (folder / name).read_bytes()
        (folder / name).write_bytes(data[: int(len(data) * keep)])

    return damage


def write(name: str, data: bytes) -> Callable[[Path], None]:
    return lambda folder: (folder / name).write_bytes(data) and None


def pose_file(T_world_camera: np.ndarray) -> Callable[[Path], None]:
    return lambda folder: np.savetxt(folder / "frame-000001.pose.txt", T_world_camera)


def image(part: str, array: np.ndarray) -> Callable[[Path], None]:
    return lambda folder: cv2.imwrite(str(folder / f"frame-000001.{part}.png"), array) and None


COLOR, DEPTH, POSE = (f"frame-000001.{end}" for end in ("color.png", "depth.png", "pose.txt"))
BAD = {
    "colour cut off": (cut(COLOR, 0.6), COLOR, "cut off"),
    "depth cut off": (cut(DEPTH, 0.9), DEPTH, "cut off"),
    "depth empty": (cut(DEPTH, 0), DEPTH, "empty file"),
    "no image": (write(COLOR, b"<html>not found"), COLOR, "neither PNG nor JPEG"),
    "colour gone": (lambda f: (f / COLOR).unlink(), "frame-000001.color", "No such file"),
    "depth gone": (lambda f: (f / DEPTH).unlink(), "frame-000001.depth", "No such file"),
    "pose gone": (lambda f: (f / POSE).unlink(), "frame-000001.pose", "No such file"),
    "depth of 8 bits": (image("depth", np.ones((48, 64), np.uint8)), DEPTH, "8 bits"),
    "colour is depth": (image("color", np.ones((48, 64), np.uint16)), COLOR, "16 bits"),
    "colour size": (image("color", np.ones((24, 32, 3), np.uint8)), COLOR, "32x24"),
    "depth size": (image("depth", np.ones((24, 32), np.uint16)), DEPTH, "32x24"),
    "pose NaN": (pose_file(np.full((4, 4), np.nan)), POSE, "not finite"),
    "pose infinite": (pose_file(np.full((4, 4), -np.inf)), POSE, "not finite"),
    "pose scaled": (pose_file(np.diag([2.0, 2, 2, 1])), POSE, "not rigid"),
    "pose mirrored": (pose_file(np.diag([1.0, 1, -1, 1])), POSE, "reflection"),
    "pose short": (write(POSE, b"1 0 0"), POSE, "expected 16 numbers, got 3"),
    "pose of words": (write(POSE, b"lost " * 16), POSE, "could not convert"),
    "pose binary": (write(POSE, b"\xff\xfe\x00" * 16), POSE, "no pose"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_frame_is_skipped_with_file_and_reason(tmp_path: Path, case: str) -> None:
    damage, where, reason = BAD[case]
    folder = write_folder(tmp_path, [0, 1, 2])
    damage(folder)
    good, bad, next_one = frames(folder)
    assert isinstance(good, RawFrame)
    assert isinstance(next_one, RawFrame)
    assert isinstance(bad, Skipped)
    assert bad.seq == 1
    assert where in bad.where
    assert reason in bad.reason


def test_a_bad_first_frame_does_not_set_the_size(tmp_path: Path) -> None:
    folder = write_folder(tmp_path, [0, 1, 2])
    cv2.imwrite(str(folder / "frame-000000.color.png"), np.ones((8, 8, 3), np.uint8))
    assert [type(f) for f in frames(folder)] == [Skipped, RawFrame, RawFrame]


def test_a_flipped_bit_in_a_depth_image_is_noticed(tmp_path: Path) -> None:
    folder = write_folder(tmp_path, [0, 1, 2])
    data = bytearray((folder / DEPTH).read_bytes())
    data[len(data) // 2] ^= 1
    (folder / DEPTH).write_bytes(data)
    bad = frames(folder)[1]
    assert isinstance(bad, Skipped)
    assert "damaged" in bad.reason


def no_intrinsics(folder: Path) -> None:
    (folder / "camera-intrinsics.txt").unlink()


def intrinsics(text: str) -> Callable[[Path], None]:
    return lambda folder: (folder / "camera-intrinsics.txt").write_text(text) and None


def stamps(text: str) -> Callable[[Path], None]:
    return lambda folder: (folder / "stamps.txt").write_text(text) and None


def color_json(text: str) -> Callable[[Path], None]:
    return lambda folder: (folder / "camera-color.json").write_text(text) and None


def larger_color(folder: Path) -> None:
    for path in folder.glob("*.color.png"):
        cv2.imwrite(str(path), np.zeros((96, 128, 3), np.uint8))


def only_bad_depth(folder: Path) -> None:
    for path in folder.glob("*.depth.png"):
        path.write_bytes(b"")


UNPLAYABLE = {
    "no intrinsics": (no_intrinsics, r"camera-intrinsics.txt: cannot be read .* 3x3"),
    "empty intrinsics": (intrinsics(""), "camera-intrinsics.txt: .* 3x3"),
    "words": (intrinsics("fx fy cx"), "camera-intrinsics.txt: could not convert"),
    "ragged": (intrinsics("1 2 3\n4 5\n6 7 8"), "camera-intrinsics.txt"),
    "NaN": (intrinsics("nan 0 3\n0 5 3\n0 0 1"), "no pinhole camera"),
    "negative focal": (intrinsics("-5 0 3\n0 5 3\n0 0 1"), "no pinhole camera"),
    "few stamps": (stamps("0.0"), "stamps.txt: 1 stamps for 2 frames"),
    "falling stamps": (stamps("1.0\n0.5"), "stamps.txt: .* grow"),
    "stamps in words": (stamps("noon\nlater"), "stamps.txt: could not convert"),
    "broken json": (color_json("{"), "camera-color.json: .*T_color_depth"),
    "json without K": (color_json('{"T_color_depth": []}'), "camera-color.json"),
    "json list": (color_json("[1, 2]"), "camera-color.json"),
    "sizes differ": (larger_color, "128x96, depth is 64x48; .*camera-color.json"),
    "no depth at all": (only_bad_depth, "no frame has a usable depth image; .*empty file"),
}


@pytest.mark.parametrize("case", UNPLAYABLE)
def test_a_folder_that_cannot_be_played_says_why(tmp_path: Path, case: str) -> None:
    damage, message = UNPLAYABLE[case]
    folder = write_folder(tmp_path, [0, 1])
    damage(folder)
    with pytest.raises(ValueError, match=message):
        opened(folder)


def test_a_missing_or_empty_folder_says_why(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="nowhere: no such folder"):
        opened(tmp_path / "nowhere")
    with pytest.raises(ValueError, match="no frames; expected frame-000000"):
        opened(tmp_path)


def test_more_rows_than_three_in_the_intrinsics_are_fine(tmp_path: Path) -> None:
    folder = write_folder(tmp_path, [0])
    wide = np.eye(4)
    wide[:3, :3] = K
    np.savetxt(folder / "camera-intrinsics.txt", wide)
    np.testing.assert_array_equal(opened(folder).depth_camera.K, K)


def test_step_must_be_positive() -> None:
    with pytest.raises(ValueError, match="step"):
        FolderParams("x", step=0)
