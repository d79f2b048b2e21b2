"""What is gone from the map, and a snapshot that still has it."""

import numpy as np
import pytest

from sceneq_core.routing.described import describe
from sceneq_core.routing.past import Gone, Past
from sceneq_core.routing.recall import with_past
from sceneq_core.routing.revision import Revision

from support.furnished import ROOM, UP, WordEncoder, furnish, instance, router

LABELLER = router().labeller


def gone(key, name="red cup"):
    descriptor = WordEncoder().encode_texts([name])[0]
    return Gone(instance(key, ROOM[5]), (), describe(descriptor, LABELLER))


def test_the_oldest_is_lost_first():
    past = Past(capacity=2)
    for key, stamp_ns in ((7, 10), (3, 20), (5, 30)):
        past.keep(gone(key), stamp_ns)
    kept = past.all()
    assert [one.geometry.instance_id for one in kept] == [3, 5]
    assert [one.geometry.state_since_ns for one in kept] == [20, 30]
    assert {one.geometry.state for one in kept} == {"removed"}


def test_what_comes_back_is_not_gone():
    past = Past()
    past.keep(gone(7), 10)
    past.forget(7)
    past.forget(8)
    assert past.all() == ()
    past.keep(gone(7), 10)
    past.clear()
    assert past.all() == ()


def test_a_snapshot_with_its_past_is_as_before_it_was_gone():
    scene = furnish()
    before = scene.snapshot()
    removed = instance(6, ROOM[5], state="removed")
    scene.apply_map(Revision(5, 13, 120, 10_000), [removed], UP, full=False)
    now = scene.snapshot()
    assert now.find(6) is None
    recalled = with_past(now, LABELLER)
    assert [one.instance_id for one in recalled.instances] == [
        one.instance_id for one in before.instances
    ]
    assert recalled.find(6) == before.find(6)
    for name in ("descriptors", "label_scores"):
        was, is_now = (np.asarray(getattr(one, name)) for one in (before, recalled))
        assert is_now == pytest.approx(was, abs=1e-6)
    assert recalled.instances[5].geometry.state == "removed"
    assert recalled.instances[5].label == before.instances[5].label
    assert with_past(recalled, LABELLER) is recalled


def test_what_was_never_answered_with_leaves_no_trace():
    scene = furnish()
    scene.apply_descriptors(5, {}, np.array([6], np.int32))
    removed = instance(6, ROOM[5], state="removed")
    scene.apply_map(Revision(5, 13, 120, 10_000), [removed], UP, full=False)
    assert scene.snapshot().past == ()
