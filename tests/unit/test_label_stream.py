"""What every instance is called, as others on the bus see it."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.reasoning.reasoner import LabelVerdict
from sceneq_core.routing.revision import Revision
from sceneq_nodes._label_stream import LabelStream
from sceneq_nodes._wire import from_bytes
from sceneq_schemas.topics import LABEL_DELTA, LABEL_SNAPSHOT

from support.fake_bus import FakeBus
from support.furnished import ROOM, descriptors, furnish, router

ROUTER = router()


@pytest.fixture
def bus():
    return FakeBus()


@pytest.fixture
def stream(bus):
    return LabelStream(bus, "room", period_s=0.0)


def published(bus):
    return [sent.message for sent in bus.published if sent.topic is LABEL_DELTA]


def snapshot_of(bus):
    return from_bytes(LABEL_SNAPSHOT, bus.query(LABEL_SNAPSHOT).payload)


def names(delta):
    return {label.instance_id: label.name for label in delta.labels}


def test_all_names_come_first_then_only_those_that_change(bus, stream):
    scene = furnish()
    stream.tick("words", ROUTER.namer, scene.snapshot())
    first = published(bus)[-1]
    assert (first.seq, first.full, first.model_id, first.map_epoch) == (1, True, "words", 5)
    assert first.label_set == "scannet200"
    assert len(first.labels) == len(ROOM)
    assert names(first)[16] == "lamp"
    assert all(label.source == "encoder" and label.accepted for label in first.labels[13:])

    stream.tick("words", ROUTER.namer, scene.snapshot())
    assert len(published(bus)) == 1

    other = descriptors((*ROOM[:15], ROOM[2]), 0.3)[16]
    scene.apply_descriptors(5, {16: other}, np.zeros(0, np.int32))
    stream.tick("words", ROUTER.namer, scene.snapshot())
    second = published(bus)[-1]
    assert (second.seq, second.full, names(second)) == (2, False, {16: "couch"})

    scene.apply_descriptors(5, {}, np.array([16], np.int32))
    stream.tick("words", ROUTER.namer, scene.snapshot())
    third = published(bus)[-1]
    assert (third.labels, third.removed.tolist()) == ((), [16])


def test_the_snapshot_is_the_sum_of_the_deltas(bus, stream):
    scene = furnish()
    assert snapshot_of(bus).labels == ()
    stream.tick("words", ROUTER.namer, scene.snapshot())
    scene.apply_descriptors(5, {}, np.array([3], np.int32))
    stream.tick("words", ROUTER.namer, scene.snapshot())
    whole = snapshot_of(bus)
    assert (whole.full, whole.seq) == (True, 2)
    assert set(names(whole)) == set(range(1, 17)) - {3}


def test_what_the_gate_does_not_accept_says_so(bus, stream):
    stream.tick("words", ROUTER.namer, furnish(noise=2.5).snapshot())
    assert not any(label.accepted for label in published(bus)[-1].labels)


def test_another_encoder_or_map_begins_anew(bus, stream):
    scene = furnish()
    stream.tick("words", ROUTER.namer, scene.snapshot())
    stream.tick("others", router().namer, scene.snapshot())
    again = published(bus)[-1]
    assert (again.seq, again.full, again.model_id, len(again.labels)) == (2, True, "others", 16)
    empty = replace(furnish(()).snapshot(), revision=Revision(6, 1, 0, 0))
    stream.tick("others", ROUTER.namer, empty)
    gone = published(bus)[-1]
    assert (gone.full, gone.labels, gone.map_epoch) == (True, (), 6)


def test_a_reasoners_name_stands_until_the_thing_looks_otherwise(bus, stream):
    scene = furnish()
    seen = scene.snapshot()
    stream.tick("words", ROUTER.namer, seen)
    proposed = ROUTER.namer.problem(seen, 15).labels
    verdict = LabelVerdict(((proposed[1][0], 0.9), (proposed[0][0], 0.1)), "it has a shade", 1)
    stream.tell(ROUTER.namer.conclude(seen, 15, verdict))
    stream.tick("words", ROUTER.namer, seen)
    (told,) = published(bus)[-1].labels
    assert (told.instance_id, told.name, told.p) == (16, proposed[1][0], 0.9)
    assert (told.source, told.accepted) == ("reasoner", True)

    scene.apply_descriptors(5, {16: descriptors(ROOM[:3], 0.3)[3]}, np.zeros(0, np.int32))
    stream.tick("words", ROUTER.namer, scene.snapshot())
    (back,) = published(bus)[-1].labels
    assert (back.name, back.source) == ("couch", "encoder")


def test_changes_are_gathered(bus):
    stream = LabelStream(bus, "room", period_s=1e6)
    scene = furnish()
    stream.tick("words", ROUTER.namer, scene.snapshot())
    scene.apply_descriptors(5, {}, np.array([3], np.int32))
    stream.tick("words", ROUTER.namer, scene.snapshot())
    assert len(published(bus)) == 1
