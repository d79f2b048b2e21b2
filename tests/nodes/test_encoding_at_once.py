"""Several instances at once, and looks ahead of their turn: faster, and nothing else."""

import threading
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np
import pytest

from sceneq_core.views.jpeg import jpeg_from_rgb
from sceneq_core.views.view import View, ViewSet
from sceneq_nodes._bus import QueryError, Reply
from sceneq_nodes._convert import view_set_message
from sceneq_nodes._look_ahead import MOST, LookAhead
from sceneq_nodes._wire import from_bytes
from sceneq_nodes.encoding import Encoding, EncodingParams
from sceneq_schemas.topics import FEATURE_DELTA, FEATURE_SNAPSHOT, VIEW_DELTA, VIEW_IMAGE
from sceneq_schemas.view import ViewDelta

from support.fake_bus import FakeBus

GONE = 90


def views_of(instance_id, *seqs):
    box = np.array([4 + instance_id, 8, 24 + instance_id, 24], np.float32)
    mask = np.ones((8, 8), bool)
    return ViewSet(instance_id, tuple(View(seq, seq, 64, box, mask) for seq in seqs))


def delta(seq, *view_sets):
    messages = tuple(view_set_message(one) for one in view_sets)
    return ViewDelta(5, seq, False, seq, seq, 1, seq, messages)


def picture(request):
    seq = int(request.parameters["seq"])
    if seq >= GONE:
        raise QueryError("not_found", f"no image of keyframe {seq}")
    rgb = np.random.default_rng(seq).integers(0, 255, (48, 64, 3), np.uint8)
    return Reply(jpeg_from_rgb(rgb), "image/jpeg")


def run(at_once):
    bus = FakeBus()
    bus.answer(VIEW_IMAGE, picture)
    params = EncodingParams(encoder={"kind": "hash"}, nice=0, at_once=at_once)
    node = Encoding(params, bus.context)
    node.open(bus)
    bus.deliver(node, VIEW_DELTA, delta(1, *(views_of(i, 10, 20, 30 + i) for i in range(1, 8))))
    bus.deliver(node, VIEW_DELTA, delta(2, views_of(3, 20, GONE), views_of(8, GONE)))
    for _ in range(10):
        node.step(None)
    node.close()
    return bus


def whole(bus):
    reply = bus.query(FEATURE_SNAPSHOT, model="hash-v1")
    return {
        one.instance_id: (one.view_seq.tolist(), one.descriptor.tobytes(), one.feature.tobytes())
        for one in from_bytes(FEATURE_SNAPSHOT, reply.payload).descriptors
    }


@pytest.mark.parametrize("at_once", [2, 5])
def test_the_descriptors_are_the_same_to_the_last_bit(at_once):
    alone, together = run(1), run(at_once)
    assert whole(together) == whole(alone)
    assert sorted(whole(alone)) == list(range(1, 8))
    assert together.counters == alone.counters
    assert alone.counters["images_gone"] == 2


def test_changes_are_told_in_the_order_of_urgency_and_not_of_speed():
    runs = [
        [one.instance_id for m in run(3).sent(FEATURE_DELTA) for one in m.descriptors]
        for _ in range(3)
    ]
    assert runs[0] == runs[1] == runs[2]
    assert runs[0][:6] == [1, 2, 4, 5, 6, 7]
    assert sorted(runs[0]) == sorted([*range(1, 8), *range(1, 8)])


@pytest.mark.parametrize("value", [0, 65])
def test_a_number_of_threads_that_makes_no_sense_is_named(value):
    with pytest.raises(ValueError, match=r"^at_once:"):
        EncodingParams(at_once=value)


class Waiting:
    """An executor that does nothing until it is told to."""

    def __init__(self):
        self.given = []

    def submit(self, look, view_set):
        self.given.append((view_set.instance_id, Future()))
        return self.given[-1][1]


def test_looks_ahead_are_few_and_each_is_done_once():
    workers, waiting = Waiting(), [views_of(i, 10) for i in range(1, 5)]
    ahead = LookAhead(workers, look=lambda view_set: None)
    for _ in range(5):
        ahead.go_on(waiting)
    assert [number for number, _ in workers.given] == [1, 2]
    assert MOST == 2
    for _, look in workers.given:
        look.set_result(None)
    waiting[0] = views_of(1, 10, 20)
    for _ in range(5):
        ahead.go_on(waiting)
    assert [number for number, _ in workers.given] == [1, 2, 1, 3]


def test_a_look_ahead_that_fails_hurts_nobody():
    tried = threading.Event()

    def look(view_set):
        tried.set()
        raise QueryError("not_found", "no image")

    with ThreadPoolExecutor(1) as workers:
        ahead = LookAhead(workers, look)
        ahead.go_on([views_of(1, GONE)])
    assert tried.is_set()
    ahead.go_on([])
