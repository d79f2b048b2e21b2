"""The recorder on a bus in memory."""

import errno
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sceneq_nodes._backends import build
from sceneq_nodes._bus import QueryError, Reply
from sceneq_nodes.recording import forms
from sceneq_nodes.recording.mcap_reader import recorded
from sceneq_nodes.recording.mcap_writer import McapWriter
from sceneq_nodes.recording.recorder import Recorder, RecorderParams
from sceneq_schemas.frame import Frame, ImageData, Pose
from sceneq_schemas.map import MapDelta
from sceneq_schemas.mask import Masks
from sceneq_schemas.topics import FRAME, MAP_DELTA, MASK, POSE, QUERY_LAST

from support.fake_bus import FakeBus

SIZE = (4, 6)


class Clock:
    def __init__(self) -> None:
        self.now_s = 10.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture
def clock() -> Clock:
    return Clock()


def frame(seq: int, after: int = -1) -> Frame:
    rgb = ImageData("raw", "|u1", (*SIZE, 3), bytes([seq] * 72))
    depth = ImageData("raw", "<u2", SIZE, bytes(48))
    K = np.diag([5.0, 5.0, 1.0])
    return Frame(seq, 1000 + 100 * seq, rgb, depth, K, np.eye(4), after)


def an_empty_delta() -> MapDelta:
    ids, points = np.zeros(0, np.int32), np.zeros((0, 3), np.float32)
    return MapDelta(
        epoch=1, seq=1, full=False, frame_seq=1, stamp_ns=1100, voxel_size_m=0.02,
        up_world=np.array([0.0, 0, 1]), voxel_id=ids, voxel_coord=np.zeros((0, 3), np.int32),
        points_world=points, rgb=points.astype(np.uint8), superpoint_id=ids,
        removed_voxel_id=ids, instances=(),
    )  # fmt: skip


def opened(path: Path, clock: Clock, **params) -> tuple[Recorder, FakeBus]:
    bus = FakeBus()
    node = Recorder(RecorderParams(str(path), **params), bus.context, clock)
    node.open(bus)
    return node, bus


def messages(path: Path) -> list[str]:
    topics = (*(v for n, v in vars(forms).items() if n.isupper() and str(v).startswith("/")),)
    return [one.topic.rpartition("/")[2] for one in recorded(path, topics)]


def seqs(path: Path) -> list[int]:
    return [f.seq for f in build("source", {"kind": "mcap", "path": str(path)}).frames()]


def test_it_writes_what_it_hears(tmp_path: Path, clock: Clock) -> None:
    path = tmp_path / "run.mcap"
    node, bus = opened(path, clock, masks=True)
    bus.deliver(node, POSE, Pose(1, 1100, np.eye(4), "given", True))
    bus.deliver(node, FRAME, frame(1))
    bus.deliver(node, MASK, Masks(1, 1100, np.ones(SIZE, np.uint16)))
    bus.deliver(node, MAP_DELTA, an_empty_delta())
    node.close()
    assert messages(path) == [
        "tf",
        "image_raw",
        "image_raw",
        "camera_info",
        "keyframe",
        "masks",
        "map",
    ]
    assert seqs(path) == [1]
    assert bus.reported["state"] == "stopped"


def test_masks_and_map_are_as_wanted(tmp_path: Path, clock: Clock) -> None:
    for name, params, left_out in (("a", {}, "/mask/"), ("b", {"map": False}, "/map/")):
        node, bus = opened(tmp_path / f"{name}.mcap", clock, **params)
        node.close()
        assert not any(left_out in key for key in bus.subscriptions)


def test_a_keyframe_sent_again_is_written_once(tmp_path: Path, clock: Clock) -> None:
    node, bus = opened(tmp_path / "run.mcap", clock)
    for one in (frame(1, 1), frame(2, 1), frame(1, 1), frame(2, 1), frame(9, 5)):
        bus.deliver(node, FRAME, one)
    node.close()
    assert seqs(tmp_path / "run.mcap") == [1, 2, 9]
    assert bus.counters == {"frames_repeated": 2, "frames_missed": 1}


def test_what_was_heard_outlives_the_process(tmp_path: Path, clock: Clock) -> None:
    path = tmp_path / "run.mcap"
    node, bus = opened(path, clock)
    bus.deliver(node, FRAME, frame(1))
    assert seqs(path) == [1]
    bus.deliver(node, POSE, Pose(2, 1200, np.eye(4), "given", False))
    clock.now_s += 2
    node.step(None)
    assert messages(path)[-1] == "tf"
    node.close()


def test_a_recorder_that_starts_again_takes_another_file(tmp_path: Path, clock: Clock) -> None:
    path = tmp_path / "run.mcap"
    for number in range(3):
        node, bus = opened(path, clock)
        bus.deliver(node, FRAME, frame(number))
        node.close()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.2.mcap", "run.3.mcap", "run.mcap"]


def test_a_damaged_keyframe_is_counted(tmp_path: Path, clock: Clock) -> None:
    node, bus = opened(tmp_path / "run.mcap", clock)
    good = frame(1)
    bus.deliver(node, FRAME, replace(good, depth_mm=replace(good.depth_mm, data=b"")))
    bus.deliver(node, FRAME, good)
    node.close()
    assert bus.counters == {"frames_bad": 1}
    assert seqs(tmp_path / "run.mcap") == [1]


def test_a_full_disk_ends_the_recording_and_nothing_else(
    tmp_path: Path, clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    node, bus = opened(tmp_path / "run.mcap", clock)
    bus.deliver(node, FRAME, frame(1))

    def full(self: McapWriter) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(McapWriter, "flush", full)
    bus.deliver(node, FRAME, frame(2))
    assert bus.reported["state"] == "failed: No space left on device"
    bus.deliver(node, FRAME, frame(3))
    assert bus.counters["messages_unrecorded"] == 4
    node.close()
    assert 1 in seqs(tmp_path / "run.mcap")


def test_it_ends_at_its_size(tmp_path: Path, clock: Clock) -> None:
    node, bus = opened(tmp_path / "run.mcap", clock, max_mb=1)
    noise = np.random.default_rng(0).integers(0, 255, (600, 600, 3), np.uint8)
    rgb = ImageData("raw", "|u1", noise.shape, noise.tobytes())
    depth = ImageData("raw", "<u2", noise.shape[:2], bytes(2 * 600 * 600))
    bus.deliver(node, FRAME, replace(frame(1), rgb=rgb, depth_mm=depth))
    assert bus.reported["state"] == "full"
    assert seqs(tmp_path / "run.mcap") == [1]


def test_answers_are_written_once_each(tmp_path: Path, clock: Clock) -> None:
    path = tmp_path / "run.mcap"
    given = [{"query_id": "b"}, {"query_id": "a"}]
    node, bus = opened(path, clock)
    bus.answer(QUERY_LAST, lambda _: Reply(json.dumps({"answers": given}).encode(), "json"))
    for _ in range(3):
        clock.now_s += 1
        node.step(None)
    given.insert(0, {"query_id": "c"})
    clock.now_s += 1
    node.step(None)
    bus.answer(QUERY_LAST, lambda _: Reply(b"[", "json"))
    clock.now_s += 1
    node.step(None)
    node.close()
    said = [
        forms.store().deserialize_cdr(o.data, o.type_name) for o in recorded(path, [forms.ANSWERS])
    ]
    assert [json.loads(one.data)["query_id"] for one in said] == ["a", "b", "c"]
    assert bus.counters == {"answers_bad": 1}


def test_a_front_door_that_refuses_is_left_alone(tmp_path: Path, clock: Clock) -> None:
    node, bus = opened(tmp_path / "run.mcap", clock)

    def busy(_):
        raise QueryError("busy", "later")

    bus.answer(QUERY_LAST, busy)
    node.step(None)
    node.close()
    assert messages(tmp_path / "run.mcap") == []


@pytest.mark.parametrize(
    ("params", "said"), [({"max_mb": -1}, "max_mb"), ({"flush_s": 0.0}, "flush_s")]
)
def test_bad_parameters_are_named(params: dict, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        RecorderParams("run.mcap", **params)


def test_a_folder_that_is_not_there_is_named(tmp_path: Path, clock: Clock) -> None:
    with pytest.raises(ValueError, match=r"nowhere/run.mcap: No such file"):
        opened(tmp_path / "nowhere" / "run.mcap", clock)
