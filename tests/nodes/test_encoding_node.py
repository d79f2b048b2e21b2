"""The encoding node on a bus in memory: followed, latest wins, gone, bad and unreachable input."""

import numpy as np
import pytest

from sceneq_core.encoding.hash import HashEncoder, HashParams
from sceneq_core.views.jpeg import jpeg_from_rgb
from sceneq_core.views.view import View, ViewSet
from sceneq_nodes import encoding
from sceneq_nodes._bus import QueryError, Reply
from sceneq_nodes._convert import view_set_message
from sceneq_nodes._wire import from_bytes
from sceneq_nodes.encoding import Encoding, EncodingParams
from sceneq_schemas.codec import encode
from sceneq_schemas.feature import FeatureDelta
from sceneq_schemas.topics import (
    FEATURE_DELTA,
    FEATURE_SNAPSHOT,
    VIEW_DELTA,
    VIEW_IMAGE,
)
from sceneq_schemas.view import View as ViewMessage
from sceneq_schemas.view import ViewDelta
from sceneq_schemas.view import ViewSet as ViewSetMessage

from support.fake_bus import FakeBus

EPOCH = 5
MODEL = "hash-v1"
RED, GREEN = (205, 25, 35), (40, 140, 60)
PICTURES = {10: RED, 20: GREEN, 30: RED}


def view_set(instance_id, *seqs, x=8):
    box, mask = np.array([x, 8, x + 16, 24], np.float32), np.ones((8, 8), bool)
    views = tuple(View(seq, seq * 100, 64, box, mask) for seq in seqs)
    return view_set_message(ViewSet(instance_id, views))


def delta(seq, *view_sets, full=False, epoch=EPOCH, map_epoch=1):
    return ViewDelta(epoch, seq, full, 10 * seq, 1000 * seq, map_epoch, seq, tuple(view_sets))


def picture(request):
    seq = int(request.parameters["seq"])
    if seq not in PICTURES:
        raise QueryError("not_found", f"no image of keyframe {seq}")
    return Reply(jpeg_from_rgb(np.full((48, 64, 3), PICTURES[seq], np.uint8)), "image/jpeg")


@pytest.fixture
def bus():
    bus = FakeBus()
    bus.answer(VIEW_IMAGE, picture)
    return bus


@pytest.fixture
def node(bus):
    node = Encoding(EncodingParams(encoder={"kind": "hash"}, nice=0), bus.context)
    node.open(bus)
    return node


def work(node, steps=10):
    for _ in range(steps):
        node.step(None)


def told(bus) -> list[FeatureDelta]:
    """What was published, without the marks of silence."""
    sent = bus.sent(FEATURE_DELTA)
    return [delta for delta in sent if delta.descriptors or len(delta.removed)]


def described(bus):
    return [one.instance_id for m in told(bus) for one in m.descriptors]


def snapshot(bus):
    return from_bytes(FEATURE_SNAPSHOT, bus.query(FEATURE_SNAPSHOT, model=MODEL).payload)


def test_each_instance_is_described_by_its_views(bus, node):
    bus.deliver(node, VIEW_DELTA, delta(1, view_set(1, 10), view_set(2, 20)))
    assert described(bus) == []
    assert bus.reported["pending"] == 2
    work(node)
    assert (bus.reported["pending"], bus.reported["described"]) == (0, 2)
    first, second = told(bus)
    assert (first.seq, second.seq) == (1, 2)
    assert (first.frame_seq, first.stamp_ns, first.model_id) == (10, 1000, MODEL)
    assert described(bus) == [1, 2]
    texts = HashEncoder(HashParams()).encode_texts(["red", "green"])
    cosines = [one.descriptors[0].descriptor @ texts.T for one in (first, second)]
    assert np.argmax(cosines, axis=1).tolist() == [0, 1]
    assert first.descriptors[0].view_seq.tolist() == [10]


def test_the_snapshot_is_the_sum_of_the_deltas(bus, node):
    assert snapshot(bus).seq == 0
    bus.deliver(node, VIEW_DELTA, delta(1, view_set(2, 20), view_set(1, 10)))
    work(node)
    whole = snapshot(bus)
    assert whole.full
    mark = bus.sent(FEATURE_DELTA)[-1]
    assert (whole.epoch, whole.seq) == (mark.epoch, mark.seq)
    assert [one.instance_id for one in whole.descriptors] == [1, 2]


def test_only_the_latest_views_are_encoded_and_history_leaves_no_trace(bus, node):
    bus.deliver(node, VIEW_DELTA, delta(1, view_set(1, 10)))
    bus.deliver(node, VIEW_DELTA, delta(2, view_set(1, 20)))
    work(node)
    assert described(bus) == [1]
    bus.deliver(node, VIEW_DELTA, delta(3, view_set(1, 20, 30)))
    work(node)
    slow = snapshot(bus).descriptors[0]
    other = FakeBus()
    other.answer(VIEW_IMAGE, picture)
    direct = Encoding(EncodingParams(encoder={"kind": "hash"}, nice=0), other.context)
    direct.open(other)
    other.deliver(direct, VIEW_DELTA, delta(1, view_set(1, 30, 20)))
    work(direct)
    quick = snapshot(other).descriptors[0]
    assert slow.descriptor.tobytes() == quick.descriptor.tobytes()
    assert slow.view_seq.tolist() == quick.view_seq.tolist() == [20, 30]


def test_every_instance_is_answerable_before_one_is_refined(bus, node):
    bus.deliver(node, VIEW_DELTA, delta(1, view_set(1, 20, 10, 30), view_set(2, 10, 20)))
    work(node)
    assert described(bus) == [1, 2, 1, 2]
    looks = [m.descriptors[0].view_seq.tolist() for m in told(bus)]
    assert looks == [[20], [10], [10, 20, 30], [10, 20]]


def test_each_picture_is_fetched_once(bus, node):
    bus.deliver(node, VIEW_DELTA, delta(1, view_set(1, 10), view_set(2, 10, x=20)))
    work(node)
    assert [r.parameters["seq"] for r in bus.asked if r.topic is VIEW_IMAGE] == ["10"]


def test_an_instance_that_is_gone_takes_its_descriptor_along(bus, node):
    bus.deliver(node, VIEW_DELTA, delta(1, view_set(1, 10), view_set(2, 20)))
    work(node)
    bus.deliver(node, VIEW_DELTA, delta(2, view_set(1), view_set(3)))
    assert told(bus)[-1].removed.tolist() == [1]
    assert [one.instance_id for one in snapshot(bus).descriptors] == [2]


def test_a_restart_of_views_on_the_same_map_takes_no_descriptor_away(bus, node):
    bus.deliver(node, VIEW_DELTA, delta(1, view_set(1, 10), view_set(2, 20)))
    work(node)
    bus.deliver(node, VIEW_DELTA, delta(1, view_set(3, 10), full=True, epoch=EPOCH + 1))
    work(node)
    assert [m.removed.tolist() for m in told(bus)] == [[], [], []]
    assert [one.instance_id for one in snapshot(bus).descriptors] == [1, 2, 3]


def test_views_that_know_no_map_yet_change_nothing(bus, node):
    bus.deliver(node, VIEW_DELTA, delta(1, view_set(1, 10)))
    work(node)
    before = snapshot(bus)
    nothing = delta(1, full=True, epoch=EPOCH + 1, map_epoch=0)
    bus.deliver(node, VIEW_DELTA, nothing)
    work(node)
    assert encode(snapshot(bus)) == encode(before)


def test_another_map_means_other_instances(bus, node):
    bus.deliver(node, VIEW_DELTA, delta(1, view_set(1, 10), view_set(2, 20)))
    work(node)
    bus.deliver(node, VIEW_DELTA, delta(2, view_set(1, 20), view_set(4, 30)))
    bus.deliver(node, VIEW_DELTA, delta(3, view_set(1, 20), full=True, map_epoch=2))
    work(node)
    assert [(m.map_epoch, m.full) for m in told(bus)] == [(1, True), (1, False), (2, True)]
    whole = snapshot(bus)
    assert whole.map_epoch == 2
    assert [(one.instance_id, one.view_seq.tolist()) for one in whole.descriptors] == [(1, [20])]


def test_views_whose_picture_is_gone_are_skipped(bus, node):
    bus.deliver(node, VIEW_DELTA, delta(1, view_set(1, 10, 77), view_set(2, 78)))
    work(node)
    assert described(bus) == [1, 1]
    assert told(bus)[-1].descriptors[0].view_seq.tolist() == [10]
    assert bus.counters["images_gone"] == 2
    assert bus.counters["instances_unseen"] == 1


def test_pictures_that_do_not_decode_are_skipped(bus, node):
    bus.answer(VIEW_IMAGE, lambda request: Reply(b"no picture", "image/jpeg"))
    bus.deliver(node, VIEW_DELTA, delta(1, view_set(1, 10)))
    work(node)
    assert bus.counters["images_bad"] == 1
    assert described(bus) == []


def test_instances_wait_while_nobody_answers_for_pictures(bus, node, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(encoding.time, "monotonic", lambda: now[0])
    bus.answer(VIEW_IMAGE, lambda request: None)
    bus.deliver(node, VIEW_DELTA, delta(1, view_set(1, 10)))
    work(node)
    assert bus.counters["pictures_unreachable"] == 1
    bus.answer(VIEW_IMAGE, picture)
    work(node)
    assert described(bus) == []
    now[0] += 1.5
    work(node)
    assert described(bus) == [1]


def test_a_view_set_that_does_not_decode_is_skipped(bus, node):
    broken = ViewSetMessage(1, (ViewMessage(10, 0, 4, np.zeros(4, np.float32), (8, 8), b"x"),))
    bus.deliver(node, VIEW_DELTA, delta(1, broken, view_set(2, 20)))
    work(node)
    assert bus.counters["view_sets_bad"] == 1
    assert described(bus) == [2]


@pytest.mark.parametrize(
    ("name", "value"), [("pictures", 0), ("nice", -1), ("nice", 20), ("turn_s", -1)]
)
def test_bad_parameters_are_named(name, value):
    with pytest.raises(ValueError, match=f"^{name}:"):
        EncodingParams(**{name: value})


def test_the_first_silence_is_marked_so_that_a_lost_last_delta_is_noticed(bus, node):
    bus.deliver(node, VIEW_DELTA, delta(1, view_set(1, 10)))
    work(node)
    *_, last, mark = bus.sent(FEATURE_DELTA)
    assert (len(last.descriptors), len(mark.descriptors), mark.seq) == (1, 0, last.seq + 1)
    node.step(None)
    assert bus.sent(FEATURE_DELTA)[-1].seq == mark.seq
