"""A small recording of a boxed room: what is written fits together and can be played."""

import hashlib
import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from sceneq_core.frame import Frame
from sceneq_core.ingest.source import RawFrame
from sceneq_nodes._files_segmenter import FilesSegmenter, FilesSegmenterParams
from sceneq_nodes._folder_source import FolderParams, FolderSource
from sceneq_tools.cli import app
from sceneq_tools.errors import UserError
from sceneq_tools.room.light.quality import Quality
from sceneq_tools.room.light.renderer import Renderer
from sceneq_tools.room.models.shapes import ParametricLibrary
from sceneq_tools.room.truth.truth import Period
from sceneq_tools.synth import Plan, SynthParams, record, write_truth
from sceneq_tools.synth_command import command_line

from support.boxed_room import boxed_room
from support.room_edit import edited

PARAMS = SynthParams(seed=5, kind="office", frames=6, rate_hz=5.0, size=(96, 72), clean=True)
COARSE = Quality(shadow_rays=2, gather_rays=4, bounces=1, cell_m=0.3, edge_rays=0, threads=1)


def poses(count: int) -> list[np.ndarray]:
    """Looks from the middle of the room along x, and goes slowly sideways."""
    turns = np.eye(4)
    turns[:3, :3] = np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])
    path = [turns.copy() for _ in range(count)]
    for k, T_world_camera in enumerate(path):
        T_world_camera[:3, 3] = (1.5, 1.4 + 0.03 * k, 1.1)
    return path


def plan() -> Plan:
    room = boxed_room()
    periods = (Period(0, room), Period(4, edited(room), ("the mug was moved",)))
    return Plan(PARAMS, ParametricLibrary(), tuple(poses(6)), periods)


def write(folder: Path) -> Path:
    folder.mkdir()
    planned = plan()
    renderer = Renderer(planned.periods[0].room, COARSE)
    ticks: list[int] = []
    truth = record(planned, renderer, folder, ticks.append)
    assert ticks == [1] * 6
    write_truth(planned, truth, folder, command_line(planned, folder.name))
    return folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("synth") / "office")


def png(folder: Path, number: int, part: str) -> np.ndarray:
    image = cv2.imread(str(folder / f"frame-{number:06d}.{part}.png"), cv2.IMREAD_UNCHANGED)
    assert image is not None
    return image


def points_world(folder: Path, number: int) -> np.ndarray:
    """The depth image as points (H, W, 3) in the world."""
    K = np.loadtxt(folder / "camera-intrinsics.txt")
    T_world_camera = np.loadtxt(folder / f"frame-{number:06d}.pose.txt")
    depth = png(folder, number, "depth") / 1000
    v, u = np.mgrid[: depth.shape[0], : depth.shape[1]]
    rays = np.stack([(u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1], np.ones_like(depth)], -1)
    return (rays * depth[..., None]) @ T_world_camera[:3, :3].T + T_world_camera[:3, 3]


def box_at(record: dict, frame: int) -> list | None:
    return [stay["box"] for stay in record["history"] if stay["from_frame"] <= frame][-1]


def test_every_file_is_there(folder: Path) -> None:
    parts = ("color.jpg", "depth.png", "pose.txt", "instance.png", "mask.png")
    frames = {f"frame-{n:06d}.{part}" for n in range(6) for part in parts}
    others = {
        "camera-intrinsics.txt", "stamps.txt", "instances.json", "queries.json",
        "ATTRIBUTION.txt", "README.md",
    }  # fmt: skip
    assert {path.name for path in folder.iterdir()} == frames | others


def test_it_is_played_by_the_folder_source(folder: Path) -> None:
    source = FolderSource(FolderParams(str(folder)))
    frames = list(source.frames())
    assert all(isinstance(frame, RawFrame) for frame in frames)
    assert [frame.stamp_ns for frame in frames] == [k * 200_000_000 for k in range(6)]
    assert source.has_poses
    np.testing.assert_allclose(source.depth_camera.K, PARAMS.camera.K, rtol=1e-6)


def test_its_masks_are_read_by_the_files_segmenter(folder: Path) -> None:
    segmenter = FilesSegmenter(FilesSegmenterParams(str(folder)))
    rgb = np.zeros((72, 96, 3), np.uint8)
    depth_m = np.ones((72, 96), np.float32)
    frame = Frame(2, 0, rgb, depth_m, PARAMS.camera.K, np.eye(4))
    assert segmenter.segment(frame).max() > 3


def test_points_lie_in_the_box_of_their_instance_at_that_time(folder: Path) -> None:
    records = json.loads((folder / "instances.json").read_text())["instances"]
    for number in range(6):
        points, ids = points_world(folder, number), png(folder, number, "instance")
        assert (ids > 0).mean() > 0.5
        for row in records:
            inside = points[ids == row["id"]]
            if len(inside):
                low, high = np.array(box_at(row, number))
                assert (inside > low - 0.003).all(), row["name"]
                assert (inside < high + 0.003).all(), row["name"]


def test_frames_agree_on_where_surfaces_are(folder: Path) -> None:
    met = png(folder, 0, "depth") > 0
    points, ids = points_world(folder, 0)[met], png(folder, 0, "instance")[met]
    K = np.loadtxt(folder / "camera-intrinsics.txt")
    T_camera_world = np.linalg.inv(np.loadtxt(folder / "frame-000003.pose.txt"))
    depth, other_ids = png(folder, 3, "depth") / 1000, png(folder, 3, "instance")
    local = points @ T_camera_world[:3, :3].T + T_camera_world[:3, 3]
    u, v = np.round(local[:, :2] / local[:, 2:] * K[[0, 1], [0, 1]] + K[:2, 2]).astype(int).T
    inside = (u >= 0) & (v >= 0) & (u < 96) & (v < 72)
    seen, same = depth[v[inside], u[inside]], other_ids[v[inside], u[inside]]
    apart = np.abs(local[inside, 2] - seen)
    agree = (same == ids[inside]) & (apart < 0.05)
    assert agree.mean() > 0.9
    assert np.median(apart[agree]) < 0.01


def test_pixels_and_frames_are_those_of_the_images(folder: Path) -> None:
    records = json.loads((folder / "instances.json").read_text())["instances"]
    images = np.stack([png(folder, n, "instance") for n in range(6)])
    for row in records:
        of_it = images == row["id"]
        assert row["pixels"] == of_it.sum()
        assert row["frames"] == of_it.any((1, 2)).sum()
    assert not (set(np.unique(images).tolist()) - {0} - {row["id"] for row in records})


def test_a_change_is_in_the_pictures_and_in_the_history(folder: Path) -> None:
    records = json.loads((folder / "instances.json").read_text())["instances"]
    book = next(row for row in records if row["name"] == "book_01")
    assert [stay["from_frame"] for stay in book["history"]] == [0, 4]
    assert box_at(book, 5) is None
    assert (png(folder, 3, "instance") == book["id"]).any()
    assert not (png(folder, 4, "instance") == book["id"]).any()


def test_targets_are_instances(folder: Path) -> None:
    names = {
        row["name"] for row in json.loads((folder / "instances.json").read_text())["instances"]
    }
    queries = json.loads((folder / "queries.json").read_text())["queries"]
    assert {target for query in queries for target in query["targets"]} <= names
    assert any(query["bucket"] == "absent" for query in queries)


def test_the_readme_holds_the_command(folder: Path) -> None:
    command = "sceneq synth office --seed 5 --frames 6 --room office --rate 5 --size 96x72 --clean"
    assert f"    {command}\n" in (folder / "README.md").read_text()


def test_the_same_seed_writes_the_same_bytes(folder: Path, tmp_path: Path) -> None:
    again = write(tmp_path / "office")
    assert digests(again) == digests(folder)


def digests(folder: Path) -> dict[str, str]:
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in sorted(folder.iterdir())}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--size", "640"], "size: expected WIDTHxHEIGHT"),
        (["--size", "8x8"], "size: each side must be"),
        (["--room", "cellar"], "kind: expected one of kitchen"),
        (["--rate", "0"], "rate_hz: must be positive"),
        (["--frames", "2", "--changes"], "frames: a room that changes needs"),
    ],
)
def test_bad_options_are_told_in_one_line(tmp_path: Path, options: list[str], message: str) -> None:
    out = tmp_path / "out"
    result = CliRunner().invoke(app, ["synth", str(out), *options])
    assert isinstance(result.exception, UserError)
    assert message in str(result.exception)
    assert not out.exists()


def test_a_folder_with_other_files_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("dear")
    result = CliRunner().invoke(app, ["synth", str(tmp_path), "--frames", "1"])
    assert isinstance(result.exception, UserError)
    assert "not empty" in str(result.exception)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]
