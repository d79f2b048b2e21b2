"""The same room in the files of many programs: each becomes the map, and answers a question."""

import json
import sys
import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import ModuleType

import cv2
import numpy as np
import pytest

from sceneq_core.ingest.quaternion import quaternion_of
from sceneq_nodes._bus import Context
from sceneq_nodes._source_kinds import need_kind
from sceneq_nodes.recording import forms
from sceneq_nodes.recording.mcap_reader import recorded
from sceneq_nodes.recording.recorder import Recorder, RecorderParams
from sceneq_schemas.topics import QUERY_INSTANCES
from sceneq_tools.batch import Batch
from sceneq_tools.collect import collect
from sceneq_tools.import_command import run as run_import
from sceneq_tools.map_plan import map_plan
from sceneq_tools.playing import play

from support import bags, data_sets, more_data_sets
from support.live_graph import write_graph
from support.recording import write_recording
from support.room import Room

FRAMES = 6
STATUSES = ("found", "ambiguous", "not_found")
"""The graph's encoder has no idea of words: that it answers is what counts."""
ROOM = Room(size=(160, 120), focal_px=130.0)
LENS = {"SIZE": ROOM.size, "K": np.asarray(ROOM.K)}


@cache
def shot(number: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return colour, millimetres and pose of a frame of the room."""
    rgb, depth_mm, _, T_world_camera = ROOM.frame(number, FRAMES)
    return rgb, depth_mm, T_world_camera


def arkit(number: int) -> list[float]:
    T_arkit = np.linalg.inv(WORLD) @ shot(number)[2] @ more_data_sets.ARKIT
    return [*quaternion_of(T_arkit[:3, :3]), *T_arkit[:3, 3]]


WORLD = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])


@pytest.fixture(autouse=True)
def the_writers_write_the_room(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the writers of the tests' wall show the room instead."""
    zipped = ModuleType("liblzfse")
    zipped.compress, zipped.decompress = zlib.compress, zlib.decompress
    monkeypatch.setitem(sys.modules, "liblzfse", zipped)
    large = np.asarray(ROOM.K) * np.array([[2.0], [2.0], [1.0]])
    large[:2, 2] += 0.5
    shown = {
        **LENS,
        "LARGE_K": large,
        "color": lambda number: shot(number)[0],
        "depth_mm": lambda number: shot(number)[1].copy(),
        "pose": lambda number: shot(number)[2],
        "arkit_pose": arkit,
        "NODE_S": 1 / 30,
        "FPS": 30,
        "STEP_NS": 33_333_333,
    }
    for module in (data_sets, more_data_sets, bags):
        for name, value in shown.items():
            if hasattr(module, name):
                monkeypatch.setattr(module, name, value)


def folder(path: Path) -> Path:
    return write_recording(path, FRAMES, ROOM)


def converted(path: Path) -> Path:
    run_import(folder(path / "folder"), path / "room.mcap", quiet=True)
    return path / "room.mcap"


def tum(path: Path) -> Path:
    """Write images without loss and poses at their stamps."""
    for part in ("rgb", "depth"):
        (path / part).mkdir(parents=True)
    lines: dict[str, list[str]] = {"rgb": [], "depth": [], "groundtruth": []}
    for number in range(FRAMES):
        rgb, depth_mm, T_world_camera = shot(number)
        stamp = f"{1e9 + number / 30:.6f}"
        cv2.imwrite(f"{path}/rgb/{stamp}.png", rgb[..., ::-1])
        cv2.imwrite(f"{path}/depth/{stamp}.png", (depth_mm * 5.0).astype(np.uint16))
        for part in ("rgb", "depth"):
            lines[part].append(f"{stamp} {part}/{stamp}.png")
        turned = quaternion_of(T_world_camera[:3, :3])
        pose = " ".join(repr(float(v)) for v in (*T_world_camera[:3, 3], *turned))
        lines["groundtruth"].append(f"{stamp} {pose}")
    for name, texts in lines.items():
        (path / f"{name}.txt").write_text("\n".join(texts) + "\n")
    np.savetxt(path / "camera-intrinsics.txt", ROOM.K)
    return path


def replica(path: Path) -> Path:
    written = data_sets.write_replica(path / "room", FRAMES)
    (fx, _, cx), (_, fy, cy), _ = np.asarray(ROOM.K).tolist()
    camera = {"w": ROOM.size[0], "h": ROOM.size[1], "fx": fx, "fy": fy, "cx": cx, "cy": cy}
    document = {"camera": {**camera, "scale": data_sets.REPLICA_SCALE}}
    (path / "cam_params.json").write_text(json.dumps(document))
    return written


def r3d(path: Path) -> Path:
    document = more_data_sets.write_r3d(path.with_suffix(".r3d"), FRAMES, zlib.compress)
    return with_camera(document)


def with_camera(path: Path) -> Path:
    """Say the camera of the room in the metadata."""
    import zipfile

    with zipfile.ZipFile(path) as old:
        parts = {name: old.read(name) for name in old.namelist()}
    metadata = json.loads(parts["metadata"])
    metadata["K"] = data_sets.LARGE_K.T.ravel().tolist()
    parts["metadata"] = json.dumps(metadata).encode()
    with zipfile.ZipFile(path, "w") as new:
        for name, data in parts.items():
            new.writestr(name, data)
    return path


def sens(path: Path) -> Path:
    path.mkdir()
    (path / "room.sens").write_bytes(data_sets.sens_bytes(FRAMES))
    return path


EXACT: dict[str, Callable[[Path], Path]] = {
    "folder": folder,
    "mcap": converted,
}
"""Layouts that keep every bit of images and poses."""
LAYOUTS: dict[str, Callable[[Path], Path]] = {
    **EXACT,
    "redwood": lambda path: more_data_sets.write_redwood(path, FRAMES),
    "rtabmap": lambda path: more_data_sets.write_rtabmap(path.with_suffix(".db"), FRAMES),
    "r3d": r3d,
    "rosbag": lambda path: bags.write_bag2(path, FRAMES),
    "rosbag 1": lambda path: bags.write_bag1(path.with_suffix(".bag"), FRAMES),
    "tum": tum,
    "replica": replica,
    "scannet": sens,
}
"""The others round poses, lose a frame or pack colour: the map is much the same."""


def mapped(path: Path, graph: Path) -> tuple[str, dict, dict]:
    """Return the digest, the scene document and the answer to a question."""
    path.parent.mkdir(exist_ok=True)
    batch = Batch(map_plan(path, graph, scene="room", segmenter="rgbd"))
    try:
        play(batch.stages(), quiet=True)
        files = collect(batch.get, batch.scene)
        answer = batch.get(QUERY_INSTANCES, {"q": "table"})
        assert not batch.troubles() or "rtabmap" in need_kind(path)
        document = files.document(files.cloud())
        return document["digest"], document, json.loads(answer.payload)
    finally:
        batch.close()


@pytest.fixture(scope="module")
def graph(tmp_path_factory: pytest.TempPathFactory) -> Path:
    where = tmp_path_factory.mktemp("graph")
    where.joinpath("none").mkdir()
    return write_graph(where, where / "none", segmenter="rgbd")


@pytest.fixture(scope="module")
def reference(tmp_path_factory: pytest.TempPathFactory, graph: Path) -> tuple[str, dict]:
    digest, document, answer = mapped(folder(tmp_path_factory.mktemp("room") / "room"), graph)
    assert document["instance_count"] >= 4
    assert answer["status"] in STATUSES
    return digest, document


@pytest.mark.parametrize("layout", sorted(LAYOUTS))
def test_a_room_in_any_layout_becomes_its_map(
    layout: str, tmp_path: Path, graph: Path, reference: tuple[str, dict]
) -> None:
    path = LAYOUTS[layout](tmp_path / "room")
    assert need_kind(path) == layout.partition(" ")[0]
    digest, document, answer = mapped(path, graph)
    assert answer["status"] in STATUSES
    if layout in EXACT:
        assert digest == reference[0]
    few, many = sorted((document["instance_count"], reference[1]["instance_count"]))
    assert few >= 0.7 * many


def test_a_run_on_odometry_is_recorded_with_its_corrections(tmp_path: Path) -> None:
    path = write_recording(tmp_path / "room", 16, ROOM)
    graph = write_graph(tmp_path, path, segmenter="rgbd")
    eager = "rate_hz: 0, pose_graph: {news_m: 0.0001, news_deg: 0.005},"
    graph.write_text(graph.read_text().replace("rate_hz: 0,", eager))
    plan = map_plan(path, graph, scene="room", no_poses=True, segmenter="rgbd")
    context = Context("recorder", plan.scene, plan.robot, plan.sensor)
    recorder = Recorder(RecorderParams(str(tmp_path / "run.mcap"), masks=True), context)
    live = Batch(plan, {"recorder": recorder})
    try:
        play(live.stages(), quiet=True)
        files = collect(live.get, live.scene)
        was = files.document(files.cloud())["digest"]
    finally:
        live.close()
    corrections = list(recorded(tmp_path / "run.mcap", [forms.CORRECTION]))
    assert len(corrections) >= 1
    assert len(list(recorded(tmp_path / "run.mcap", [forms.MASKS]))) == 16
    assert mapped(tmp_path / "run.mcap", graph)[0] == was
