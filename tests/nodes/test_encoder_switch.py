"""From one encoder to another: answers come from the old one until the new one covers the map."""

import json
from threading import Event

import numpy as np
import pytest

from sceneq_core.mapping.delta import MapDelta
from sceneq_nodes._backends import BACKENDS
from sceneq_nodes._convert import map_delta_message
from sceneq_nodes.routing import Routing
from sceneq_schemas.feature import Descriptor, FeatureDelta
from sceneq_schemas.topics import (
    FEATURE_DELTA,
    MAP_DELTA,
    QUERY_INSTANCES,
    QUERY_STATUS,
    VIEW_DELTA,
)
from sceneq_schemas.view import View, ViewDelta, ViewSet

from support import other_words
from support.fake_bus import FakeBus
from support.furnished import ROOM, UP, WordEncoder, instance
from support.other_words import OtherWords

EPOCH = 5
OLD, NEW = WordEncoder(), OtherWords()
LABELS = ("lamp", "chair", "bathtub")
IDS = range(1, len(ROOM) + 1)


@pytest.fixture(autouse=True)
def plug_in_both_encoders(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setitem(BACKENDS["encoder"], "words", "support.furnished:WordEncoder")
    monkeypatch.setitem(BACKENDS["encoder"], "other", "support.other_words:OtherWords")


def routing(*, wait=True, **changes):
    params = Routing.Params(
        **{"encoder": {"kind": "other"}, "meanwhile": {"kind": "words"}, "labels": LABELS} | changes
    )
    bus = FakeBus()
    bus.node_params = params
    bus.node = Routing(params, bus.context)
    bus.node.open(bus)
    box = np.array([1.0, 2.0, 30.0, 40.0], np.float32)
    sets = tuple(ViewSet(i, (View(10 * i, 5, 99, box, (0, 0), b""),)) for i in IDS)
    bus.deliver(bus.node, MAP_DELTA, map_message())
    bus.deliver(bus.node, VIEW_DELTA, ViewDelta(1, 1, True, 10, 1_000, EPOCH, 1, sets))
    if wait:
        arrive(bus)
    return bus


def arrive(bus):
    """Let the node run until it follows the descriptors of the encoder it was given."""
    model = OLD.model_id if bus.node_params.encoder["kind"] == "words" else NEW.model_id
    while not bus.subscribes(FEATURE_DELTA, {"scene": "room", "model": model}):
        bus.node.step(None)


def map_message():
    none = np.zeros(0, np.int32)
    delta = MapDelta(
        full=True,
        frame_seq=10,
        stamp_ns=1_000,
        voxel_size_m=0.02,
        up_world=UP,
        voxel_id=none,
        voxel_coord=np.zeros((0, 3), np.int32),
        points_world=np.zeros((0, 3), np.float32),
        rgb=np.zeros((0, 3), np.uint8),
        superpoint_id=none,
        removed_voxel_id=none,
        instances=tuple(instance(i, thing) for i, thing in zip(IDS, ROOM, strict=True)),
    )
    return map_delta_message(delta, EPOCH, 1)


def describe(bus, encoder, ids, seq=1, *, key=None, epoch=1):
    vectors = encoder.encode_texts([ROOM[i - 1].name for i in ids])
    none = np.zeros(0, np.float32)
    rows = tuple(
        Descriptor(i, np.array([10], np.int64), row, none)
        for i, row in zip(ids, vectors, strict=True)
    )
    removed = np.zeros(0, np.int32)
    delta = FeatureDelta(*(epoch, seq, seq == 1, 10, 1_000, encoder.model_id), rows, removed, EPOCH)
    bus.deliver(bus.node, FEATURE_DELTA, delta, model=key or encoder.model_id)


def ask(bus, topic, **parameters):
    return json.loads(bus.query(topic, parameters=parameters).payload)


def status(bus):
    return ask(bus, QUERY_STATUS)


def test_the_old_encoder_answers_until_the_new_one_covers_the_map():
    bus = routing(cover=1.0)
    describe(bus, OLD, IDS)
    describe(bus, NEW, [1, 2])
    assert (status(bus)["model"], status(bus)["answerable"]) == ("words", len(ROOM))
    assert status(bus)["next_covers"] == round(2 / len(ROOM), 3)
    before = ask(bus, QUERY_INSTANCES, q="lamp")
    describe(bus, NEW, range(3, len(ROOM) + 1), seq=2)
    assert (status(bus)["model"], status(bus)["answerable"]) == ("other-words", len(ROOM))
    assert "next_covers" not in status(bus)
    after = ask(bus, QUERY_INSTANCES, q="lamp")
    assert [one["id"] for one in after["instances"]][:1] == [before["instances"][0]["id"]]
    assert bus.counters["encoder_switches"] == 1


def test_every_answer_is_from_one_encoder_only():
    bus = routing(cover=1.0)
    describe(bus, OLD, IDS)
    for seq, instance_id in enumerate(IDS, start=1):
        describe(bus, NEW, [instance_id], seq=seq)
        answer = ask(bus, QUERY_INSTANCES, q="lamp")
        assert len(answer["instances"]) >= 1
        assert status(bus)["answerable"] == len(ROOM)
    assert status(bus)["model"] == "other-words"


def test_a_share_is_enough_where_some_pictures_are_gone():
    bus = routing(cover=0.5)
    describe(bus, OLD, IDS)
    describe(bus, NEW, IDS[: len(ROOM) // 2 + 1])
    assert status(bus)["model"] == "other-words"
    assert status(bus)["answerable"] == len(ROOM) // 2 + 1


def test_there_is_no_way_back_and_what_still_comes_is_let_by():
    bus = routing()
    describe(bus, OLD, [1])
    describe(bus, NEW, [1])
    describe(bus, OLD, IDS, seq=2)
    assert (status(bus)["model"], status(bus)["answerable"]) == ("other-words", 1)
    assert set(status(bus)["synced"]) == {"map_delta", "view_delta", "feature_delta"}


def test_without_anything_described_before_the_new_encoder_answers_at_once():
    bus = routing()
    assert status(bus)["model"] == "words"
    describe(bus, NEW, [2])
    assert (status(bus)["model"], status(bus)["answerable"]) == ("other-words", 1)


def test_the_same_encoder_twice_is_one():
    bus = routing(meanwhile={"kind": "other"})
    assert status(bus)["model"] == "other-words"
    assert "next_covers" not in status(bus)


def test_descriptors_of_another_model_than_their_key_are_refused():
    bus = routing(meanwhile=None, encoder={"kind": "words"})
    describe(bus, NEW, IDS, key="words")
    assert status(bus)["answerable"] == 0
    assert bus.counters["descriptors_refused"] == 1
    describe(bus, OLD, IDS, seq=2)
    assert status(bus)["answerable"] == len(ROOM)


def test_the_old_encoder_answers_while_the_new_one_loads(monkeypatch):
    go = Event()

    class Slow(OtherWords):
        def encode_texts(self, texts):
            go.wait(60)
            return super().encode_texts(texts)

    monkeypatch.setattr(other_words, "OtherWords", Slow)
    bus = routing(wait=False)
    describe(bus, OLD, IDS)
    assert (status(bus)["model"], status(bus)["next_covers"]) == ("words", 0.0)
    assert len(ask(bus, QUERY_INSTANCES, q="lamp")["instances"]) >= 1
    go.set()
    arrive(bus)
    describe(bus, NEW, IDS)
    assert (status(bus)["model"], status(bus)["answerable"]) == ("other-words", len(ROOM))


def test_a_new_encoder_that_cannot_load_leaves_the_old_one_at_work(monkeypatch):
    class Broken(OtherWords):
        def encode_texts(self, texts):
            raise ValueError("weights.bin: no weights")

    monkeypatch.setattr(other_words, "OtherWords", Broken)
    bus = routing(wait=False)
    describe(bus, OLD, IDS)
    while not bus.counters["encoder_failed"]:
        bus.node.step(None)
    assert (status(bus)["model"], status(bus)["answerable"]) == ("words", len(ROOM))
    assert "next_covers" not in status(bus)


def test_the_share_is_checked():
    with pytest.raises(ValueError, match=r"^cover:"):
        Routing.Params(cover=1.5)
