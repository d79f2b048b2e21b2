"""The mapping node on the bus in memory."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.mapping.replica import MapReplica
from sceneq_nodes._bus import QueryError
from sceneq_nodes._convert import map_delta_from_message
from sceneq_nodes._images import frame_message
from sceneq_nodes._params import ParamError, validate
from sceneq_nodes._wire import from_bytes
from sceneq_nodes.mapping import Mapping, MappingParams
from sceneq_schemas.codec import encode
from sceneq_schemas.mask import Masks
from sceneq_schemas.topics import FRAME, MAP_DELTA, MAP_JOURNAL, MAP_SNAPSHOT, MASK

from support.fake_bus import FakeBus
from support.surfaces import SMALL, room_frames

VIEWS = room_frames(5)


def opened(**params):
    bus = FakeBus()
    node = Mapping(MappingParams(mapper=SMALL, **params), bus.context)
    node.open(bus)
    return node, bus


def frame_of(seq):
    return frame_message(VIEWS[seq][0], "raw", "raw")


def masks_of(seq):
    frame, instance = VIEWS[seq]
    return Masks(frame.seq, frame.stamp_ns, instance)


def show(node, bus, *seqs):
    for seq in seqs:
        bus.deliver(node, FRAME, frame_of(seq))
        bus.deliver(node, MASK, masks_of(seq))


def snapshot(bus):
    reply = bus.query(MAP_SNAPSHOT)
    assert reply.encoding == MAP_SNAPSHOT.encoding
    return from_bytes(MAP_SNAPSHOT, reply.payload)


def test_every_keyframe_gives_one_delta_with_epoch_and_running_seq():
    node, bus = opened()
    show(node, bus, 0, 1, 2)
    deltas = bus.sent(MAP_DELTA)
    assert [d.seq for d in deltas] == [1, 2, 3]
    assert [d.frame_seq for d in deltas] == [0, 1, 2]
    assert len({d.epoch for d in deltas}) == 1
    assert bus.counters == {"frames_integrated": 3}
    assert bus.reported["instances"] == len(snapshot(bus).instances) > 0


def test_the_halves_of_a_keyframe_may_come_in_any_order():
    node, bus = opened()
    bus.deliver(node, MASK, masks_of(1))
    bus.deliver(node, FRAME, frame_of(0))
    bus.deliver(node, FRAME, frame_of(1))
    bus.deliver(node, MASK, masks_of(0))
    assert [d.frame_seq for d in bus.sent(MAP_DELTA)] == [1, 0]


def test_no_frame_overtakes_the_one_it_is_sent_after():
    node, bus = opened()

    def send(seq, after):
        bus.deliver(node, FRAME, replace(frame_of(seq), after=after))
        bus.deliver(node, MASK, masks_of(seq))

    send(0, 0)
    send(2, 1)
    send(3, 2)
    assert [d.frame_seq for d in bus.sent(MAP_DELTA)] == [0]
    send(1, 0)
    assert [d.frame_seq for d in bus.sent(MAP_DELTA)] == [0, 1, 2, 3]


def test_a_map_that_begins_later_waits_for_nothing_from_before():
    node, bus = opened()
    for seq in (2, 1, 3):
        bus.deliver(node, FRAME, replace(frame_of(seq), after=seq - 1))
        bus.deliver(node, MASK, masks_of(seq))
    assert [d.frame_seq for d in bus.sent(MAP_DELTA)] == [2, 1, 3]


def test_the_last_deltas_are_told_again():
    node, bus = opened()
    show(node, bus, 0, 1, 2)
    epoch = bus.sent(MAP_DELTA)[0].epoch

    def told(**parameters):
        reply = bus.query(MAP_JOURNAL, parameters=parameters)
        return reply and from_bytes(MAP_JOURNAL, reply.payload)

    missed = told(epoch=str(epoch), after="1")
    assert (missed.epoch, missed.seq) == (epoch, 3)
    assert [encode(d) for d in missed.deltas] == [encode(d) for d in bus.sent(MAP_DELTA)[1:]]
    with pytest.raises(QueryError, match="forgotten"):
        told(epoch="5", after="1")
    assert [d.seq for d in told(epoch="0", after="0").deltas] == [1, 2, 3]


def test_deltas_add_up_to_the_snapshot():
    node, bus = opened()
    show(node, bus, 0, 1, 2, 3)
    replica, whole = MapReplica(), MapReplica()
    for delta in bus.sent(MAP_DELTA):
        replica.apply(map_delta_from_message(delta))
    message = snapshot(bus)
    whole.apply(map_delta_from_message(message))
    assert (message.full, message.seq, message.frame_seq) == (True, 4, 3)
    for one, other in zip(replica.cloud(), whole.cloud(), strict=True):
        assert np.array_equal(one, other)


def test_the_snapshot_before_the_first_frame_is_empty_and_has_the_epoch():
    node, bus = opened()
    before = snapshot(bus)
    show(node, bus, 0)
    assert (before.full, before.seq, len(before.voxel_id)) == (True, 0, 0)
    assert before.epoch == bus.sent(MAP_DELTA)[0].epoch


def test_a_resent_frame_is_acknowledged_again_and_not_integrated_twice():
    node, bus = opened()
    show(node, bus, 0, 1, 0)
    again = bus.sent(MAP_DELTA)[2]
    assert (again.seq, again.frame_seq) == (3, 0)
    assert (len(again.voxel_id), again.instances) == (0, ())
    assert bus.counters["frames_repeated"] == 1
    assert snapshot(bus).frame_seq == 1


def test_a_lone_half_is_given_up_when_enough_newer_ones_wait():
    node, bus = opened(max_waiting=2)
    for seq in range(4):
        bus.deliver(node, FRAME, frame_of(seq))
    assert bus.counters["frames_unmatched"] == 2
    bus.deliver(node, MASK, masks_of(0))
    bus.deliver(node, MASK, masks_of(3))
    assert [d.frame_seq for d in bus.sent(MAP_DELTA)] == [3]


def test_segments_of_another_size_are_refused_and_the_next_frame_is_taken():
    node, bus = opened()
    bus.deliver(node, FRAME, frame_of(0))
    bus.deliver(node, MASK, Masks(0, 0, np.zeros((4, 4), np.uint16)))
    show(node, bus, 1)
    assert bus.counters["frames_refused"] == 1
    assert [(d.seq, d.frame_seq) for d in bus.sent(MAP_DELTA)] == [(1, 0), (2, 1)]
    assert bus.sent(MAP_DELTA)[0].instances == ()


def test_a_frame_that_does_not_decode_is_refused():
    node, bus = opened()
    broken = frame_message(VIEWS[0][0], "raw", "raw")
    object.__setattr__(broken.rgb, "data", broken.rgb.data[:-1])
    bus.deliver(node, FRAME, broken)
    bus.deliver(node, MASK, masks_of(0))
    assert bus.counters == {"frames_refused": 1}


def test_the_first_silence_is_marked_so_that_a_lost_last_delta_is_noticed():
    node, bus = opened()
    show(node, bus, 0, 1)
    for _ in range(3):
        node.step(None)
    mark = bus.sent(MAP_DELTA)[2:]
    assert [(m.seq, m.frame_seq, len(m.voxel_id), m.instances) for m in mark] == [(3, 1, 0, ())]
    show(node, bus, 2)
    node.step(None)
    assert [m.seq for m in bus.sent(MAP_DELTA)] == [1, 2, 3, 4, 5]


def test_an_idle_step_and_close_do_nothing():
    node, bus = opened()
    node.step(None)
    node.close()
    assert bus.published == []


def test_parameters_come_from_nested_maps():
    params = validate(MappingParams, {"mapper": {"instances": {"min_views": 3}}})
    assert params.mapper.instances.min_views == 3
    with pytest.raises(ParamError, match=r"mapper\.voxel_size_m"):
        validate(MappingParams, {"mapper": {"voxel_size_m": "wide"}})
    with pytest.raises(ValueError, match="max_waiting"):
        MappingParams(max_waiting=0)
