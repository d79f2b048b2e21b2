"""The views node on a bus in memory: joined, late, repeated, bad and lost input."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.views.jpeg import jpeg_size
from sceneq_core.views.selector import ViewSelector
from sceneq_nodes._bus import QueryError, Reply
from sceneq_nodes._convert import map_delta_message, view_set_message
from sceneq_nodes._images import frame_message
from sceneq_nodes._recent_deltas import FORGOTTEN
from sceneq_nodes._wire import from_bytes, to_bytes
from sceneq_nodes.mapping import MappingParams
from sceneq_nodes.segmentation import SegmentationParams
from sceneq_nodes.views import Views, ViewsParams
from sceneq_schemas.codec import encode
from sceneq_schemas.map import MapDeltas
from sceneq_schemas.topics import (
    FRAME,
    MAP_DELTA,
    MAP_JOURNAL,
    MAP_SNAPSHOT,
    VIEW_DELTA,
    VIEW_IMAGE,
    VIEW_SNAPSHOT,
)

from support.fake_bus import FakeBus
from support.room import Room
from support.true_map import TrueMap, delta, frame_of, instance

FRAMES = 4
EPOCH = 11
ROOM = Room()


@pytest.fixture(scope="module")
def stream():
    """Return the frame messages, the map deltas and the map of a short run."""
    true_map, frames, deltas = TrueMap(ROOM), [], []
    for i in range(FRAMES):
        frame, things = frame_of(ROOM, i, FRAMES)
        frames.append(frame_message(frame, "raw", "zstd"))
        deltas.append(map_delta_message(true_map.integrate(frame, things), EPOCH, i + 1))
    return frames, deltas, true_map


@pytest.fixture
def bus() -> FakeBus:
    return FakeBus()


def opened(bus: FakeBus, params: ViewsParams | None = None) -> Views:
    node = Views(params or ViewsParams(), bus.context)
    node.open(bus)
    return node


def acknowledged(bus: FakeBus) -> list[int]:
    return [message.frame_seq for message in bus.sent(VIEW_DELTA)]


def forgotten(_request):
    raise QueryError(FORGOTTEN, "not all of these deltas are known")


def snapshot(bus: FakeBus):
    return from_bytes(VIEW_SNAPSHOT, bus.query(VIEW_SNAPSHOT).payload)


def run(bus: FakeBus, node: Views, stream) -> None:
    frames, deltas, _ = stream
    for frame, change in zip(frames, deltas, strict=True):
        bus.deliver(node, FRAME, frame)
        bus.deliver(node, MAP_DELTA, change)


def test_every_keyframe_is_acknowledged_when_the_map_holds_it(bus, stream):
    frames, deltas, _ = stream
    node = opened(bus)
    bus.deliver(node, FRAME, frames[0])
    assert acknowledged(bus) == []
    bus.deliver(node, MAP_DELTA, deltas[0])
    assert acknowledged(bus) == [0]
    run(bus, node, (frames[1:], deltas[1:], None))
    sent = bus.sent(VIEW_DELTA)
    assert [m.frame_seq for m in sent] == [0, 1, 2, 3]
    assert [m.seq for m in sent] == [1, 2, 3, 4]
    assert [m.stamp_ns for m in sent] == [0, 1000, 2000, 3000]
    assert [(m.map_epoch, m.map_seq) for m in sent] == [(EPOCH, i + 1) for i in range(4)]
    assert bus.reported["keyframes"] == 4
    node.close()


def test_deltas_add_up_to_the_snapshot(bus, stream):
    run(bus, opened(bus), stream)
    told = {s.instance_id: s for m in bus.sent(VIEW_DELTA) for s in m.view_sets if s.views}
    whole = snapshot(bus)
    assert whole.full
    assert (whole.seq, whole.frame_seq) == (4, 3)
    assert [s.instance_id for s in whole.view_sets] == sorted(told)
    for view_set in whole.view_sets:
        assert [v.seq for v in view_set.views] == [v.seq for v in told[view_set.instance_id].views]


def test_a_frame_may_come_after_its_map(bus, stream):
    frames, deltas, _ = stream
    node = opened(bus)
    bus.deliver(node, MAP_DELTA, deltas[0])
    bus.deliver(node, MAP_DELTA, deltas[1])
    assert acknowledged(bus) == []
    bus.deliver(node, FRAME, frames[0])
    bus.deliver(node, FRAME, frames[1])
    assert acknowledged(bus) == [0, 1]


def test_a_repeated_frame_is_acknowledged_again_but_not_looked_at(bus, stream):
    frames, _, _ = stream
    node = opened(bus)
    run(bus, node, stream)
    bus.deliver(node, FRAME, frames[3])
    bus.deliver(node, FRAME, frames[1])
    assert acknowledged(bus) == [0, 1, 2, 3, 3, 1]
    assert bus.sent(VIEW_DELTA)[-1].view_sets == ()
    assert bus.counters["frames_observed"] == 4


def test_a_frame_that_the_map_keeps_out_is_acknowledged_but_not_looked_at(bus, stream):
    frames, deltas, _ = stream
    node = opened(bus)
    out = replace(deltas[1], quarantined="pose jumped: 5.0 m and 0 degrees in 0.1 s")
    run(bus, node, (frames[:3], [deltas[0], out, deltas[2]], None))
    assert acknowledged(bus) == [0, 1, 2]
    assert bus.counters == {"frames_observed": 2, "frames_kept_out": 1}
    shown = {view.seq for view_set in snapshot(bus).view_sets for view in view_set.views}
    assert shown <= {0, 2}


def test_frames_the_map_never_takes_in_are_let_go_and_counted(bus, stream):
    frames, deltas, _ = stream
    node = opened(bus, ViewsParams(waiting=2))
    for frame in frames:
        bus.deliver(node, FRAME, frame)
    assert bus.counters["frames_unmatched"] == 2
    for change in deltas:
        bus.deliver(node, MAP_DELTA, change)
    assert acknowledged(bus) == [2, 3]


def test_frames_wait_longer_than_those_before_can_lag_behind():
    behind = SegmentationParams().inbox + 2 * MappingParams().max_waiting
    assert ViewsParams().waiting > behind


def test_a_frame_that_does_not_decode_is_acknowledged_skipped_and_counted(bus, stream):
    frames, deltas, _ = stream
    node = opened(bus)
    bus.deliver(node, FRAME, replace(frames[0], T_world_camera=np.full((4, 4), np.nan)))
    bus.deliver(node, MAP_DELTA, deltas[0])
    assert bus.counters["frames_bad"] == 1
    run(bus, node, (frames[1:], deltas[1:], None))
    assert acknowledged(bus) == [0, 1, 2, 3]
    assert bus.counters["frames_observed"] == 3


def test_after_a_restart_of_the_map_every_view_set_is_told(bus, stream):
    true_map = stream[2]
    node = opened(bus)
    run(bus, node, stream)
    again = replace(map_delta_message(true_map.snapshot(), EPOCH + 1, 1), frame_seq=9)
    bus.deliver(node, MAP_DELTA, again)
    node.step(None)
    first, second = (m for m in bus.sent(VIEW_DELTA) if m.full)
    assert (first.map_epoch, second.map_epoch) == (EPOCH, EPOCH + 1)
    bus.deliver(node, FRAME, stream[0][0])
    assert len(bus.sent(VIEW_DELTA)) == FRAMES + 1, "not acknowledged before the new map holds it"
    told = [view_set.instance_id for view_set in second.view_sets]
    assert told == [view_set.instance_id for view_set in snapshot(bus).view_sets]
    assert set(told) <= {one.instance_id for one in again.instances}
    assert len(told) >= 3


def test_a_map_delta_that_contradicts_itself_is_skipped_and_counted(bus, stream):
    _, deltas, _ = stream
    node = opened(bus)
    bus.deliver(node, MAP_DELTA, replace(deltas[0], rgb=np.zeros((1, 3), np.uint8)))
    assert bus.counters["map_delta_bad"] == 1


def test_a_lost_map_delta_is_healed_from_the_snapshot(bus, stream):
    frames, deltas, true_map = stream
    node = opened(bus)
    bus.deliver(node, FRAME, frames[0])
    bus.deliver(node, MAP_DELTA, deltas[0])
    bus.answer(MAP_JOURNAL, forgotten)
    whole = map_delta_message(true_map.snapshot(), EPOCH, 4)
    bus.answer(MAP_SNAPSHOT, lambda _: Reply(to_bytes(MAP_SNAPSHOT, whole), ""))
    for frame in frames[1:]:
        bus.deliver(node, FRAME, frame)
    node._map._next_ask = 0.0
    bus.deliver(node, MAP_DELTA, deltas[3])
    assert acknowledged(bus) == [0, 1, 2, 3]


def test_a_writer_on_its_way_back_is_waited_for(bus, stream):
    """It may still know every change; in the whole map older keyframes would look otherwise."""
    frames, deltas, true_map = stream
    node = opened(bus)
    bus.deliver(node, FRAME, frames[0])
    bus.deliver(node, MAP_DELTA, deltas[0])
    whole = map_delta_message(true_map.snapshot(), EPOCH, 4)
    bus.answer(MAP_SNAPSHOT, lambda _: Reply(to_bytes(MAP_SNAPSHOT, whole), ""))
    for frame in frames[1:]:
        bus.deliver(node, FRAME, frame)
    node._map._next_ask = 0.0
    bus.deliver(node, MAP_DELTA, deltas[3])
    assert acknowledged(bus) == [0]
    missed = MapDeltas(EPOCH, 3, tuple(deltas[1:3]))
    bus.answer(MAP_JOURNAL, lambda _: Reply(to_bytes(MAP_JOURNAL, missed), ""))
    node._map._next_ask = 0.0
    node.step(None)
    assert acknowledged(bus)[:4] == [0, 1, 2, 3]


def test_a_change_without_a_keyframe_is_told_when_it_is_quiet(bus, stream):
    node = opened(bus)
    run(bus, node, stream)
    gone = delta(frame_seq=9, instances=(instance(4, [], state="removed"),))
    bus.deliver(node, MAP_DELTA, map_delta_message(gone, EPOCH, 5))
    assert len(bus.sent(VIEW_DELTA)) == 4
    node.step(None)
    last = bus.sent(VIEW_DELTA)[-1]
    assert [(s.instance_id, s.views) for s in last.view_sets] == [(4, ())]
    assert last.frame_seq == 3
    assert 4 not in [s.instance_id for s in snapshot(bus).view_sets]
    node.step(None)
    assert len(bus.sent(VIEW_DELTA)) == 5


def test_the_first_silence_is_marked_so_that_a_lost_last_delta_is_noticed(bus, stream):
    node = opened(bus)
    run(bus, node, stream)
    for _ in range(3):
        node.step(None)
    mark = bus.sent(VIEW_DELTA)[4:]
    assert [(m.seq, m.frame_seq, m.view_sets) for m in mark] == [(5, 3, ())]


def test_the_snapshot_is_there_before_anything_happened(bus):
    opened(bus)
    empty = snapshot(bus)
    assert (empty.seq, empty.frame_seq, empty.view_sets) == (0, -1, ())


def test_images_are_served_with_and_without_a_box(bus, stream):
    run(bus, opened(bus), stream)
    plain = bus.query(VIEW_IMAGE, parameters={"seq": "2"})
    boxed = bus.query(VIEW_IMAGE, parameters={"seq": "2", "box": "10,20,60,80"})
    assert plain.encoding == boxed.encoding == "image/jpeg"
    assert jpeg_size(plain.payload) == jpeg_size(boxed.payload) == (120, 160)
    assert plain.payload != boxed.payload


@pytest.mark.parametrize(
    ("parameters", "code"),
    [
        ({}, "bad_request"),
        ({"seq": "two"}, "bad_request"),
        ({"seq": "2", "box": "1,2,3"}, "bad_request"),
        ({"seq": "2", "box": "1,2,3,nan"}, "bad_request"),
        ({"seq": "99"}, "not_found"),
    ],
)
def test_bad_image_requests_are_told_so(bus, parameters, code):
    opened(bus)
    with pytest.raises(QueryError) as error:
        bus.query(VIEW_IMAGE, parameters=parameters)
    assert error.value.code == code


def test_a_wildcard_without_seq_gets_no_image(bus):
    opened(bus)
    assert bus.query(VIEW_IMAGE, wildcard=True) is None


def test_parameters_are_checked():
    with pytest.raises(ValueError, match="waiting"):
        ViewsParams(waiting=0)


def test_the_node_names_the_views_that_the_selector_alone_names(bus, stream):
    run(bus, opened(bus), stream)
    selector, true_map = ViewSelector(), TrueMap(ROOM)
    for i in range(FRAMES):
        frame, things = frame_of(ROOM, i, FRAMES)
        selector.observe(frame, true_map.integrate(frame, things))
    alone = tuple(view_set_message(view_set) for view_set in selector.view_sets())
    assert encode(replace(snapshot(bus), view_sets=alone)) == bus.query(VIEW_SNAPSHOT).payload
