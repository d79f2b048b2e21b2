"""The ingest node on a bus in memory, with a clock that the tests move."""

import json
import logging
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sceneq_core.ingest.source import Camera, RawFrame, RefusedError
from sceneq_nodes import ingest as ingest_module
from sceneq_nodes._bus import QueryError
from sceneq_nodes._images import frame_from_message
from sceneq_nodes._ingesting import IngestSpecs, new_ingestor, open_source
from sceneq_nodes.ingest import Ingest, IngestParams
from sceneq_nodes.mapping import MappingParams
from sceneq_nodes.segmentation import SegmentationParams
from sceneq_nodes.views import ViewsParams
from sceneq_schemas.topics import CONTROL, FRAME, POSE, VIEW_DELTA
from sceneq_schemas.view import ViewDelta

from support.fake_bus import FakeBus
from support.seven_scenes import color, write_folder


class Clock:
    """Stands in for the ``time`` module."""

    def __init__(self) -> None:
        self.now_s = 1000.0

    def monotonic(self) -> float:
        return self.now_s


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(ingest_module, "time", clock)
    return clock


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_folder(tmp_path / "shelf", list(range(12)))


def opened(folder: Path, **params) -> tuple[Ingest, FakeBus]:
    values = {"keyframes": {"kind": "every", "every": 2}, "wait_for": (), **params}
    bus = FakeBus()
    source = {"kind": "folder", "path": str(folder)} | values.pop("source", {})
    node = Ingest(IngestParams(source=source, **values), bus.context)
    node.open(bus)
    return node, bus


def seqs(bus: FakeBus, topic) -> list[int]:
    return [message.seq for message in bus.sent(topic)]


def acknowledge(bus: FakeBus, node: Ingest, seq: int) -> None:
    bus.deliver(node, VIEW_DELTA, ViewDelta(1, 1, False, seq, 0, 1, 1, ()))


def start(bus: FakeBus, node: Ingest) -> None:
    """Let the first keyframe go, which goes alone, and acknowledge it."""
    node.step(None)
    acknowledge(bus, node, 0)


def test_lossless_play_keeps_a_window(folder: Path, clock: Clock) -> None:
    node, bus = opened(folder, window=2)
    node.step(None)
    node.step(None)
    assert seqs(bus, FRAME) == [0]
    acknowledge(bus, node, 0)
    assert seqs(bus, FRAME) == [0, 2, 4]
    assert seqs(bus, POSE) == [0, 1, 2, 3, 4]
    acknowledge(bus, node, 2)
    assert seqs(bus, FRAME) == [0, 2, 4, 6]
    for seq in (4, 6, 8, 10):
        acknowledge(bus, node, seq)
    assert seqs(bus, FRAME) == [0, 2, 4, 6, 8, 10]
    assert [frame.after for frame in bus.sent(FRAME)] == [0, 0, 2, 4, 6, 8]
    assert seqs(bus, POSE) == list(range(12))
    assert bus.reported == {"state": "finished", "frames": 12, "keyframes": 6}
    node.step(None)
    node.close()
    assert not bus.counters


def test_play_is_finished_with_the_last_acknowledgement(folder: Path, clock: Clock) -> None:
    node, bus = opened(folder, window=9)
    start(bus, node)
    assert bus.reported["state"] == "ending"
    for seq in (2, 4, 6, 8):
        acknowledge(bus, node, seq)
    assert bus.reported["state"] == "ending"
    acknowledge(bus, node, 10)
    assert bus.reported["state"] == "finished"


def test_what_nobody_acknowledges_is_sent_again_and_given_up(
    folder: Path, clock: Clock, caplog: pytest.LogCaptureFixture
) -> None:
    node, bus = opened(folder, window=1, resend_s=1.0, tries=2, source={"step": 6})
    node.step(None)
    clock.now_s += 1.0
    node.step(None)
    first, again = bus.sent(FRAME)
    assert (first.seq, again.seq) == (0, 0)
    assert again.rgb == first.rgb
    assert bus.counters == {"frames_resent": 1}
    clock.now_s += 2.0
    node.step(None)
    assert bus.counters["frames_lost"] == 1
    assert "keyframe 0 lost" in caplog.text
    assert bus.reported["state"] == "finished"
    assert seqs(bus, POSE) == [0, 6]


def test_the_source_starts_again_when_mapping_or_views_do(folder: Path, clock: Clock) -> None:
    node, bus = opened(folder, window=1, replays=2)

    def map_holds(seq: int, map_epoch: int, epoch: int = 1) -> None:
        bus.deliver(node, VIEW_DELTA, ViewDelta(epoch, 1, False, seq, 0, map_epoch, 1, ()))

    node.step(None)
    map_holds(0, 7)
    map_holds(2, 0)  # views knows no map yet
    map_holds(4, 7)
    assert seqs(bus, FRAME) == [0, 2, 4, 6]
    map_holds(6, 8)
    assert seqs(bus, FRAME) == [0, 2, 4, 6, 0]
    map_holds(0, 8, epoch=2)
    assert seqs(bus, FRAME) == [0, 2, 4, 6, 0, 0]
    map_holds(0, 10)  # it is no use
    assert seqs(bus, FRAME) == [0, 2, 4, 6, 0, 0, 2]
    assert bus.counters["replays"] == 2
    for seq in (2, 4, 6, 8, 10):
        map_holds(seq, 10)
    assert bus.reported["state"] == "finished"
    assert bus.reported["keyframes"] == 6


def test_paced_play_follows_the_clock_and_waits_for_nobody(folder: Path, clock: Clock) -> None:
    node, bus = opened(folder, rate_hz=10.0, window=1)
    assert not bus.subscriptions
    sent = []
    for _ in range(24):
        node.step(None)
        sent.append(len(bus.sent(POSE)))
        clock.now_s += 0.0501
    assert sent == [1 + tick // 2 for tick in range(24)]
    assert bus.counters["frames_late"] == 0
    node.step(None)
    assert bus.reported == {"state": "finished", "frames": 12, "keyframes": 6}


def test_late_frames_follow_at_once_and_are_counted(folder: Path, clock: Clock) -> None:
    node, bus = opened(folder, rate_hz=10.0)
    node.step(None)
    clock.now_s += 0.55
    node.step(None)
    assert seqs(bus, POSE) == [0, 1, 2, 3, 4, 5]
    assert bus.counters == {"frames_late": 4}


def test_messages_say_what_the_source_said(folder: Path, clock: Clock) -> None:
    node, bus = opened(folder, rgb_codec="raw", depth_codec="zstd", source={"step": 2})
    start(bus, node)
    pose = bus.sent(POSE)[2]
    assert (pose.seq, pose.stamp_ns, pose.source, pose.keyframe) == (4, 133_333_333, "given", True)
    assert pose.T_world_camera[0, 3] == pytest.approx(0.04)
    assert [p.keyframe for p in bus.sent(POSE)[:2]] == [True, False]
    frame = frame_from_message(bus.sent(FRAME)[1])
    assert frame.seq == 4
    np.testing.assert_array_equal(frame.rgb, color(4))
    assert frame.depth_m[5, 5] == np.float32(2004) * np.float32(0.001)


def test_streamed_keyframes_equal_those_of_a_single_process(folder: Path, clock: Clock) -> None:
    node, bus = opened(folder, window=9)
    start(bus, node)
    specs = IngestSpecs({"kind": "folder", "path": str(folder)}, {"kind": "every", "every": 2})
    source = open_source(specs)
    ingestor = new_ingestor(source, specs)
    direct = [ingestor.ingest(raw).keyframe for raw in source.frames() if isinstance(raw, RawFrame)]
    streamed = [frame_from_message(message) for message in bus.sent(FRAME)]
    for ours, theirs in zip(filter(None, direct), streamed, strict=True):
        assert (ours.seq, ours.stamp_ns) == (theirs.seq, theirs.stamp_ns)
        for name in ("rgb", "depth_m", "K", "T_world_camera"):
            assert getattr(ours, name).tobytes() == getattr(theirs, name).tobytes()


def test_bad_frames_are_counted_and_logged_with_file_and_reason(
    folder: Path, clock: Clock, caplog: pytest.LogCaptureFixture
) -> None:
    (folder / "frame-000002.color.png").write_bytes(b"")
    (folder / "frame-000005.pose.txt").unlink()
    np.savetxt(folder / "frame-000007.pose.txt", np.full((4, 4), np.nan))
    with caplog.at_level(logging.WARNING):
        node, bus = opened(folder, window=9)
        start(bus, node)
    assert bus.counters == {"frames_skipped": 3}
    assert seqs(bus, POSE) == [0, 1, 3, 4, 6, 8, 9, 10, 11]
    assert "frame-000002.color.png: empty file" in caplog.text
    assert "frame-000005.pose.txt: No such file" in caplog.text
    assert "frame-000007.pose.txt: not finite" in caplog.text


def test_it_waits_for_the_graph(folder: Path, clock: Clock) -> None:
    node, bus = opened(folder, wait_for=("mapping", "views"))
    node.step(None)
    bus.alive_nodes |= {"mapping"}
    clock.now_s += 1.0
    node.step(None)
    assert bus.reported["state"] == "waiting"
    assert not bus.published
    bus.alive_nodes |= {"views"}
    clock.now_s += 1.0
    node.step(None)
    assert bus.published


def test_it_starts_without_the_graph_after_a_while(
    folder: Path, clock: Clock, caplog: pytest.LogCaptureFixture
) -> None:
    node, bus = opened(folder, wait_for=("mapping", "views"), wait_s=5.0)
    node.step(None)
    clock.now_s += 5.0
    node.step(None)
    assert bus.published
    assert "starting without mapping, views" in caplog.text


def test_a_long_source_does_not_keep_the_node_from_its_inbox(folder: Path, clock: Clock) -> None:
    class Ticking(Clock):
        def monotonic(self) -> float:
            self.now_s += 0.02
            return self.now_s

    ingest_module.time = Ticking()  # the fixture puts the real one back
    node, bus = opened(folder, window=99, source={"loop": True})
    node.step(None)
    assert 1 <= len(bus.sent(POSE)) <= 4


def test_without_poses_the_odometry_is_named(folder: Path, clock: Clock) -> None:
    node, bus = opened(folder, source={"use_poses": False, "step": 6})
    start(bus, node)
    assert [p.source for p in bus.sent(POSE)] == ["depth_icp"] * 2


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ({"path": "/nowhere"}, "/nowhere: no such folder"),
        ({"kind": "film"}, "source.kind: unknown kind"),
        ({"steps": 2}, "source.steps: unknown key"),
    ],
)
def test_a_source_that_cannot_be_opened_is_a_value_error(
    folder: Path, source: dict, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        opened(folder, source=source)


class Box:
    """A source with one thing in it, which can be painted."""

    name = "box"
    has_poses = True
    T_color_depth = np.eye(4)

    def __init__(self) -> None:
        self.color_camera = self.depth_camera = Camera(np.eye(3), (4, 3))
        self.painted: list[dict[str, str]] = []

    def frames(self) -> Iterator[RawFrame]:
        return iter(())

    def control(self, verb: str, arguments: Mapping[str, str]) -> dict[str, Any]:
        if verb == "remove":
            raise RefusedError("it is nailed down", "paint it")
        self.painted.append(dict(arguments))
        return {"verb": verb, **arguments}


@pytest.fixture
def box(monkeypatch: pytest.MonkeyPatch, folder: Path) -> tuple[Box, FakeBus]:
    box = Box()
    monkeypatch.setattr(ingest_module, "open_source", lambda _: box)
    return box, opened(folder)[1]


def test_a_source_is_changed_by_parameters_or_by_json(box: tuple[Box, FakeBus]) -> None:
    source, bus = box
    reply = bus.query(CONTROL, verb="move", parameters={"thing": "mug", "onto": "desk"})
    assert json.loads(reply.payload) == {"verb": "move", "thing": "mug", "onto": "desk"}
    assert reply.encoding == "application/json;sceneq.control.v1"
    bus.query(CONTROL, verb="move", parameters={"thing": "mug"}, payload=b'{"thing": 17}')
    assert source.painted[1:] == [{"thing": "17"}]


def test_a_wildcard_changes_nothing(box: tuple[Box, FakeBus]) -> None:
    source, bus = box
    assert bus.query(CONTROL, verb="move", parameters={"thing": "mug"}, wildcard=True) is None
    assert bus.query(CONTROL, verb="list", wildcard=True) is not None
    assert source.painted == [{}]


@pytest.mark.parametrize(
    ("verb", "payload", "code", "hint"),
    [
        ("remove", b"", "refused", "paint it"),
        ("move", b"{", "bad_request", '{"thing": "mug"}'),
        ("move", b"[1]", "bad_request", '{"thing": "mug"}'),
        ("move", b'{"thing": {}}', "bad_request", '{"thing": "mug"}'),
    ],
)
def test_what_cannot_be_done_is_an_error_with_a_hint(
    box: tuple[Box, FakeBus], verb: str, payload: bytes, code: str, hint: str
) -> None:
    with pytest.raises(QueryError) as caught:
        box[1].query(CONTROL, verb=verb, payload=payload)
    assert (caught.value.code, caught.value.hint) == (code, hint)


def test_a_recording_cannot_be_changed(folder: Path, clock: Clock) -> None:
    _, bus = opened(folder)
    with pytest.raises(QueryError, match="a recording cannot be changed") as caught:
        bus.query(CONTROL, verb="remove", parameters={"thing": "mug"})
    assert "sceneq up --sim" in caught.value.hint


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("rate_hz", -1.0),
        ("rate_hz", float("nan")),
        ("rgb_codec", "png"),
        ("depth_codec", "jpeg"),
        ("window", 0),
        ("tries", 0),
        ("resend_s", 0.0),
    ],
)
def test_parameters_name_what_is_wrong(name: str, value: object) -> None:
    with pytest.raises(ValueError, match=name):
        IngestParams(source={}, **{name: value})


def test_what_is_on_its_way_by_default_fits_into_every_inbox() -> None:
    """A keyframe that is dropped and sent again comes late, and the map would be another one."""
    window = IngestParams(source={}).window
    assert window <= min(
        SegmentationParams().inbox, MappingParams().max_waiting, ViewsParams().waiting
    )
