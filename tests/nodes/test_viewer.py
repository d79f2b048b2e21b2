"""The viewer on a bus in memory: what it writes to a file, and what it does with bad input."""

import json
import socket
import threading
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sceneq_core.views.jpeg import jpeg_from_rgb
from sceneq_nodes import _viewer_output
from sceneq_nodes._bus import QueryError, Reply
from sceneq_nodes._convert import map_delta_message
from sceneq_nodes._images import frame_message
from sceneq_nodes._viewer_output import OutputParams
from sceneq_nodes.viewer import Viewer, ViewerParams
from sceneq_schemas.frame import ImageData
from sceneq_schemas.mask import Masks
from sceneq_schemas.topics import (
    FRAME,
    MAP_DELTA,
    MASK,
    METRIC,
    QUERY_INSTANCES,
    QUERY_LAST,
    VIEW_DELTA,
    VIEW_IMAGE,
)
from sceneq_schemas.view import ViewDelta

from support.fake_bus import FakeBus
from support.rerun_file import contents
from support.room import Room
from support.true_map import TrueMap, frame_of

FRAMES = 3
ROOM = Room()
ANSWER = {
    "query_id": "a1",
    "question": "red ball",
    "status": "found",
    "route": "fast",
    "reason": "clear",
    "took_ms": 3.4,
    "instances": [
        {
            "id": 4,
            "label": "ball",
            "p": 0.72,
            "cosine": 0.4,
            "views": [{"seq": 1, "box_xyxy": [10.0, 20.0, 60.0, 80.0], "key": "k"}],
        }
    ],
}
SHORT = {
    **{name: ANSWER[name] for name in ("query_id", "question", "status", "route", "took_ms")},
    "best": [{"id": 4, "label": "ball", "p": 0.72}],
}
EARLIER = {**SHORT, "query_id": "a0", "question": "blue box"}


@pytest.fixture(scope="module")
def stream():
    """Return frame messages, masks and map deltas of a short run."""
    true_map, frames, masks, deltas = TrueMap(ROOM), [], [], []
    for i in range(FRAMES):
        frame, things = frame_of(ROOM, i, FRAMES)
        frames.append(frame_message(frame, "jpeg" if i else "raw", "zstd"))
        masks.append(Masks(i, 1000 * i, things))
        deltas.append(map_delta_message(true_map.integrate(frame, things), 11, i + 1))
    return frames, masks, deltas


class Clock:
    """Time that passes when the test says so."""

    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture
def bus(monkeypatch) -> FakeBus:
    monkeypatch.setattr("os.nice", lambda _: 0)  # the tests after this one are not to be slow
    return FakeBus()


def reply(body) -> Reply:
    return Reply(json.dumps(body).encode(), "application/json")


def with_front_door(bus: FakeBus) -> None:
    ball = {"id": 4, "label": "ball", "p": 0.9}
    bus.answer(QUERY_INSTANCES, lambda _: reply({"instances": [ball]}))
    bus.answer(
        QUERY_LAST,
        lambda asked: reply({"answers": [ANSWER] if "k" in asked.parameters else [SHORT, EARLIER]}),
    )
    jpeg = jpeg_from_rgb(ROOM.frame(1, FRAMES)[0])
    bus.answer(VIEW_IMAGE, lambda _: Reply(jpeg, "image/jpeg"))


def opened(bus: FakeBus, path: Path, clock: Clock | None = None, **params) -> Viewer:
    output = OutputParams(save=str(path))
    node = Viewer(ViewerParams(output=output, **params), bus.context, clock or Clock())
    node.open(bus)
    return node


def run(bus: FakeBus, node: Viewer, stream, clock: Clock) -> None:
    node.step(None)
    for frame, masks, delta in zip(*stream, strict=True):
        bus.deliver(node, FRAME, frame)
        bus.deliver(node, MASK, masks)
        bus.deliver(node, MAP_DELTA, delta)
        metrics = {"frame.out": frame.seq + 1, "uptime_s": 1.0 + frame.seq, "mask.dropped": 2}
        bus.deliver(node, METRIC, {"node": "ingest", "metrics": metrics})
        clock.now_s += 4.0
        node.step(None)


def test_everything_that_is_shown_is_in_the_recording(bus, stream, tmp_path):
    with_front_door(bus)
    clock = Clock()
    node = opened(bus, tmp_path / "a.rrd", clock)
    run(bus, node, stream, clock)
    node.close()
    shown = contents(tmp_path / "a.rrd")
    assert {
        *("/world/camera", "/world/camera/rgb", "/world/camera/masks", "/world/path"),
        *("/world/colour/0", "/world/instances/0", "/world/boxes", "/world/answer"),
        *("/answers/text", "/answers/evidence/1", "/answers/evidence/1/box"),
        *("/series/rates", "/series/lost", "/series/delays"),
    } <= set(shown.entities)
    assert {"frame", "stamp", "log_time"} <= set(shown.timelines)
    assert "4 ball" in shown.texts("/world/boxes")
    assert "5" in shown.texts("/world/boxes")
    assert "4 ball  p 0.72" in shown.texts("/world/answer")
    assert "red ball" in shown.texts("/answers/text")[-1]
    assert "blue box" in shown.texts("/answers/text")[-1]
    assert "ingest" in shown.texts("/series/rates")
    assert not any(path.startswith("/world/superpoints") for path in shown.entities)
    assert bus.published == [], "a viewer is nobody's writer"


def test_superpoints_are_shown_on_demand(bus, stream, tmp_path):
    clock = Clock()
    node = opened(bus, tmp_path / "a.rrd", clock, superpoints=True)
    run(bus, node, stream, clock)
    node.close()
    assert "/world/superpoints/0" in contents(tmp_path / "a.rrd").entities


def test_the_map_is_drawn_at_the_set_rate_however_often_it_changes(bus, stream, tmp_path):
    clock = Clock()
    node = opened(bus, tmp_path / "a.rrd", clock)
    run(bus, node, stream, clock)
    asked = len(bus.asked)
    for _ in range(20):
        clock.now_s += 0.01
        node.step(None)
    assert len(bus.asked) == asked
    clock.now_s += 1.0
    node.step(None)
    assert len(bus.asked) > asked
    node.close()


def test_only_what_differs_is_logged_again(bus, stream, tmp_path):
    clock = Clock()
    node = opened(bus, tmp_path / "a.rrd", clock)
    run(bus, node, stream, clock)
    assert bus.reported["points_logged"] > 1000
    clock.now_s += 1.1
    node.step(None)
    assert bus.reported["points_logged"] == 0
    node.close()


def test_an_answer_is_fetched_once(bus, stream, tmp_path):
    with_front_door(bus)
    clock = Clock()
    node = opened(bus, tmp_path / "a.rrd", clock)
    run(bus, node, stream, clock)
    pictures = [asked for asked in bus.asked if asked.topic is VIEW_IMAGE]
    assert [asked.parameters for asked in pictures] == [{"seq": "1"}]
    node.close()


def test_it_draws_without_a_front_door_and_with_one_that_refuses(bus, stream, tmp_path):
    clock = Clock()
    node = opened(bus, tmp_path / "a.rrd", clock)
    run(bus, node, stream, clock)

    def refuse(_):
        raise QueryError("busy", "no time")

    bus.answer(QUERY_LAST, refuse)
    bus.answer(QUERY_INSTANCES, lambda _: Reply(b"{", "application/json"))
    bus.deliver(node, MAP_DELTA, replace(stream[2][-1], seq=FRAMES + 1))
    clock.now_s += 4.0
    node.step(None)
    node.close()
    assert bus.counters["last_refused"] == 1
    assert bus.counters["answers_bad"] == 1
    assert "5" in contents(tmp_path / "a.rrd").texts("/world/boxes")


@pytest.mark.parametrize(
    "broken",
    [
        {"T_world_camera": np.full((4, 4), np.nan)},
        {"K": np.full((3, 3), np.inf)},
        {"rgb": ImageData("raw", "<u2", (120, 160), bytes(38400))},
        {"rgb": ImageData("zstd", "|u1", (120, 160, 3), b"no frame")},
    ],
)
def test_bad_frames_are_counted_and_left_out(bus, stream, tmp_path, broken):
    node = opened(bus, tmp_path / "a.rrd")
    node.step(None)
    bus.deliver(node, FRAME, replace(stream[0][0], **broken))
    assert bus.counters["frames_bad"] == 1
    node.close()


@pytest.mark.parametrize("metrics", [None, {"frame.out": "many"}])
def test_metrics_without_numbers_are_counted(bus, tmp_path, metrics):
    node = opened(bus, tmp_path / "a.rrd")
    node.step(None)
    bus.deliver(node, METRIC, {"node": "views", "metrics": metrics})
    assert bus.counters["metrics_bad"] == 1
    node.close()


def test_a_delta_that_contradicts_itself_is_counted(bus, stream, tmp_path):
    node = opened(bus, tmp_path / "a.rrd")
    bus.deliver(node, MAP_DELTA, replace(stream[2][0], rgb=np.zeros((1, 3), np.uint8)))
    assert bus.counters["map_delta_bad"] == 1
    node.close()


def test_delays_count_from_the_keyframe(bus, stream, tmp_path):
    clock = Clock()
    node = opened(bus, tmp_path / "a.rrd", clock)
    node.step(None)
    bus.deliver(node, FRAME, stream[0][0])
    clock.now_s += 0.25
    bus.deliver(node, VIEW_DELTA, ViewDelta(1, 1, True, 0, 0, 11, 1, ()))
    clock.now_s += 2.0
    node.step(None)
    node.close()
    shown = contents(tmp_path / "a.rrd")
    assert shown.texts("/series/delays") == ["masks", "map", "views", "descriptors", "answer"]
    delays_ms = shown.scalars("/series/delays")[-1]
    np.testing.assert_allclose(delays_ms, [np.nan, np.nan, 250.0, np.nan, np.nan])


def test_nothing_is_kept_for_a_viewer_that_is_not_there(bus, stream):
    clock = Clock()
    output = OutputParams(connect="rerun+http://127.0.0.1:9/proxy")
    node = Viewer(ViewerParams(output=output), bus.context, clock)
    node.open(bus)
    run(bus, node, stream, clock)
    assert node._screen is None
    assert bus.counters == {}
    node.close()


@contextmanager
def deaf_viewer(bus):
    """A node for a viewer that listens and takes nothing."""
    with socket.socket() as deaf:
        deaf.bind(("127.0.0.1", 0))
        deaf.listen()
        clock = Clock()
        output = OutputParams(connect=f"rerun+http://127.0.0.1:{deaf.getsockname()[1]}/proxy")
        node = Viewer(ViewerParams(output=output), bus.context, clock)
        node.open(bus)
        yield node, clock
        node.close()


def test_a_viewer_that_takes_nothing_is_not_waited_for(bus, stream):
    with deaf_viewer(bus) as (node, clock):
        run(bus, node, stream, clock)
        assert bus.counters["messages_skipped"] >= FRAMES
        assert bus.counters["pictures_skipped"] >= FRAMES - 1


def test_a_viewer_that_never_lets_us_in_is_not_waited_for(bus, stream, monkeypatch):
    let_in = threading.Event()
    monkeypatch.setattr(_viewer_output, "OPEN_S", 0.01)
    monkeypatch.setattr(_viewer_output.Output, "_start", lambda self: let_in.wait())
    with deaf_viewer(bus) as (node, clock):
        run(bus, node, stream, clock)
        assert bus.counters["messages_skipped"] >= FRAMES
        assert bus.counters["pictures_skipped"] >= FRAMES - 1
        assert "viewers_lost" not in bus.counters
    let_in.set()


def test_without_rerun_it_says_what_to_install(bus, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "rerun", None)
    node = Viewer(ViewerParams(), bus.context)
    with pytest.raises(ValueError, match="rerun-sdk"):
        node.open(bus)


def test_a_port_in_use_is_told(bus, monkeypatch):
    def taken(host: str, port: int) -> None:
        raise ValueError(f"cannot listen on {host}:{port}: Address already in use")

    monkeypatch.setattr(_viewer_output, "_need_free", taken)
    with pytest.raises(ValueError, match=r"127\.0\.0\.1:9090"):
        Viewer(ViewerParams(), bus.context).open(bus)


@pytest.mark.parametrize(
    ("params", "field"),
    [
        ({"picture_hz": 0.0}, "picture_hz"),
        ({"max_points": 0}, "max_points"),
    ],
)
def test_parameters_are_checked(params, field):
    with pytest.raises(ValueError, match=field):
        ViewerParams(**params)
