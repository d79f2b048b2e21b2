"""The mirror holds what the writers hold, hears or asks, and its digests say so."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_nodes._bus import Reply
from sceneq_nodes._convert import map_delta_message
from sceneq_nodes._feature_journal import FeatureJournal
from sceneq_nodes._follow import Pull
from sceneq_nodes._recent_deltas import RecentDeltas, journal_reply, wanted_deltas
from sceneq_nodes._view_journal import ViewJournal
from sceneq_nodes._wire import json_bytes, to_bytes
from sceneq_nodes.mirror import Mirror, MirrorParams
from sceneq_schemas.feature import Descriptor
from sceneq_schemas.topics import (
    FEATURE_DELTA,
    FEATURE_JOURNAL,
    FEATURE_SNAPSHOT,
    MAP_DELTA,
    MAP_JOURNAL,
    MAP_SNAPSHOT,
    QUERY_STATUS,
    VIEW_DELTA,
    VIEW_JOURNAL,
    VIEW_SNAPSHOT,
)
from sceneq_schemas.view import View, ViewSet

from support.fake_bus import CONTEXT, FakeBus
from support.room import Room
from support.true_map import TrueMap, frame_of

EPOCH, MODEL, FRAMES = 11, "hash-v1", 5
ROOM = Room()


def described(instance_id: int, value: float = 1.0) -> Descriptor:
    one = np.array([value, 0.0], np.float32)
    return Descriptor(instance_id, np.array([1], np.int64), one, one)


def seen(instance_id: int, seq: int = 1) -> ViewSet:
    box = np.array([0, 0, 8, 1], np.float32)
    return ViewSet(instance_id, (View(seq, seq, 8, box, (1, 8), b"\xff"),))


class Writers:
    """Mapping, views and encoding, as their queryables answer."""

    def __init__(self, bus: FakeBus) -> None:
        self.map, self.recent, self.seq = TrueMap(ROOM), RecentDeltas(), 0
        self.views = ViewJournal(EPOCH)
        self.features = FeatureJournal(EPOCH, MODEL)
        bus.answer(MAP_JOURNAL, self.map_journal)
        bus.answer(MAP_SNAPSHOT, self.map_snapshot)
        bus.answer(VIEW_SNAPSHOT, self.views.answer)
        bus.answer(VIEW_JOURNAL, self.views.answer_changes)
        bus.answer(FEATURE_SNAPSHOT, self.features.answer, model=MODEL)
        bus.answer(FEATURE_JOURNAL, self.features.answer_changes, model=MODEL)

    def map_delta(self):
        frame, things = frame_of(ROOM, self.seq, FRAMES)
        self.seq += 1
        delta = map_delta_message(self.map.integrate(frame, things), EPOCH, self.seq)
        self.recent.add(delta)
        return delta

    def map_snapshot(self, _request) -> Reply:
        whole = map_delta_message(self.map.snapshot(), EPOCH, self.seq)
        return Reply(to_bytes(MAP_SNAPSHOT, whole), "")

    def map_journal(self, request) -> Reply | None:
        epoch, after = wanted_deltas(request)
        return journal_reply(request, epoch, self.seq, self.recent.after(after))

    def view_delta(self, *sets: ViewSet):
        return self.views.write(sets, frame_seq=1, stamp_ns=1, map_epoch=EPOCH, map_seq=1)

    def feature_delta(self, *descriptors: Descriptor, removed: tuple[int, ...] = ()):
        return self.features.write(descriptors, removed, frame_seq=1, stamp_ns=1, map_epoch=EPOCH)


@pytest.fixture
def bus() -> FakeBus:
    bus = FakeBus(replace(CONTEXT, node="mirror"))
    bus.answer(QUERY_STATUS, lambda _: Reply(json_bytes({"model": MODEL}), ""))
    return bus


@pytest.fixture
def writers(bus: FakeBus) -> Writers:
    return Writers(bus)


def opened(bus: FakeBus, **params: object) -> Mirror:
    mirror = Mirror(MirrorParams(**params), bus.context)
    mirror.open(bus)
    return mirror


def test_it_asks_the_front_door_whose_descriptors_to_keep(bus: FakeBus, writers: Writers) -> None:
    writers.feature_delta(described(1), described(2))
    mirror = opened(bus)
    mirror.step(None)
    assert bus.reported["descriptors"] == 2
    assert bus.subscribes(FEATURE_DELTA, {"scene": "room", "model": MODEL})
    assert not bus.subscribes(FEATURE_DELTA, {"scene": "room", "model": "other"})


def test_one_that_heard_everything_and_one_that_came_late_are_equal(
    bus: FakeBus, writers: Writers
) -> None:
    early = opened(bus)
    for i in range(3):
        bus.deliver(early, MAP_DELTA, writers.map_delta())
        bus.deliver(early, VIEW_DELTA, writers.view_delta(seen(i + 1), seen(i + 2)))
        gone = (i,) if i else ()
        delta = writers.feature_delta(described(i + 1, i), removed=gone)
        bus.deliver(early, FEATURE_DELTA, delta, model=MODEL)
    early.step(None)
    first = dict(bus.reported)
    assert first["map"] == f"{EPOCH}:3"
    assert first["voxels"] > 100
    assert (first["instances"] > 0, first["view_sets"], first["descriptors"]) == (True, 4, 1)
    assert first["synced"] == 1

    bus.reported.clear()
    late = opened(bus, pull=Pull(every_s=0.001, mbit_s=1000.0))
    late.step(None)
    assert {name: bus.reported[name] for name in first} == first


def test_changes_are_told_as_one(bus: FakeBus, writers: Writers) -> None:
    heard, pulled = opened(bus), None
    first = writers.map_delta()
    bus.deliver(heard, MAP_DELTA, first)
    pulled = opened(bus, pull=Pull(every_s=0.001, mbit_s=1000.0))
    pulled._followers["map"].offer(first)
    for _ in range(3):
        bus.deliver(heard, MAP_DELTA, writers.map_delta())
    heard.step(None)
    expected = bus.reported["map_digest"]
    bus.reported.clear()
    pulled.step(None)
    assert bus.reported["map"] == f"{EPOCH}:4"
    assert bus.reported["map_digest"] == expected


def test_a_lost_delta_of_views_is_healed_without_the_whole(bus: FakeBus, writers: Writers) -> None:
    mirror = opened(bus)
    bus.deliver(mirror, VIEW_DELTA, writers.view_delta(seen(1), seen(2)))
    writers.view_delta(seen(3), ViewSet(2, ()))
    bus.asked.clear()
    mirror._followers["views"]._next_ask = 0.0
    bus.deliver(mirror, VIEW_DELTA, writers.view_delta(seen(1, seq=2)))
    assert [one.topic for one in bus.asked] == [VIEW_JOURNAL]
    mirror.step(None)
    assert bus.reported["view_sets"] == 2
    assert bus.counters["view_delta_resyncs"] == 1


def test_a_delta_that_fits_no_map_is_counted(bus: FakeBus, writers: Writers) -> None:
    mirror = opened(bus)
    delta = writers.map_delta()
    bus.deliver(mirror, MAP_DELTA, replace(delta, rgb=delta.rgb[:1]))
    assert bus.counters["map_delta_bad"] == 1


def test_bad_parameters_are_named() -> None:
    with pytest.raises(ValueError, match="digest_s"):
        MirrorParams(digest_s=0)
    with pytest.raises(ValueError, match="mbit_s"):
        Pull(mbit_s=0)
    with pytest.raises(ValueError, match="every_s"):
        Pull(every_s=float("inf"))
