"""Who is described next."""

import numpy as np

from sceneq_core.encoding.pending import Pending
from sceneq_core.views.view import View, ViewSet


def view_set(instance_id, *seqs):
    box, mask = np.zeros(4, np.float32), np.ones((1, 1), bool)
    return ViewSet(instance_id, tuple(View(seq, seq, 1, box, mask) for seq in seqs))


def seqs(view_set):
    return [view.seq for view in view_set.views]


def drain(pending):
    taken = []
    while (one := pending.take()) is not None:
        pending.settle(one)
        taken.append(one.instance_id)
    return taken


def test_the_latest_view_set_replaces_the_one_that_waits():
    pending = Pending()
    pending.put(view_set(1, 10))
    pending.put(view_set(1, 10, 20))
    assert len(pending) == 1
    assert seqs(pending.take()) == [10]


def test_the_best_view_comes_first_and_the_whole_set_when_there_is_time():
    pending = Pending()
    pending.put(view_set(1, 10, 20))
    pending.put(view_set(2, 10))
    taken = []
    while (one := pending.take()) is not None:
        pending.settle(one)
        taken.append((one.instance_id, seqs(one)))
    assert taken == [(1, [10]), (2, [10]), (1, [10, 20])]


def test_new_instances_come_first_then_those_that_changed_most():
    pending = Pending()
    for one in (view_set(1, 10), view_set(2, 10), view_set(3, 10)):
        pending.put(one)
    assert drain(pending) == [1, 2, 3]
    for one in (view_set(1, 10, 20), view_set(2, 20, 30), view_set(3, 10), view_set(9, 30)):
        pending.put(one)
    assert drain(pending) == [9, 2, 1, 3]


def test_what_was_taken_but_not_settled_is_still_new():
    pending = Pending()
    pending.put(view_set(1, 10))
    drain(pending)
    pending.put(view_set(5, 10))
    pending.give_back(pending.take())
    pending.put(view_set(1, 20, 30))
    assert drain(pending) == [5, 1]


def test_what_is_given_back_does_not_replace_what_waits():
    pending = Pending()
    pending.put(view_set(1, 10, 20))
    pending.give_back(pending.take())
    pending.settle(pending.take())
    taken = pending.take()
    pending.put(view_set(1, 30))
    pending.give_back(taken)
    assert seqs(pending.take()) == [30]


def test_what_is_gone_is_forgotten():
    pending = Pending()
    pending.put(view_set(1, 10))
    pending.put(view_set(2, 10))
    drain(pending)
    pending.put(view_set(2, 20))
    pending.forget(2)
    pending.forget(77)
    assert pending.take() is None
    pending.put(view_set(1, 30))
    pending.put(view_set(2, 10))
    assert pending.take().instance_id == 2  # as if it had never been described


def test_several_are_taken_in_the_order_of_one_after_the_other():
    pending = Pending()
    for instance_id in (3, 1, 2):
        pending.put(view_set(instance_id, 10, 20))
    some = pending.take_some(2)
    assert [(one.instance_id, seqs(one)) for one in some] == [(1, [10]), (2, [10])]
    for one in some:
        pending.settle(one)
    rest = pending.take_some(5)
    assert [(one.instance_id, seqs(one)) for one in rest] == [
        (3, [10]),
        (1, [10, 20]),
        (2, [10, 20]),
    ]
    pending.settle(rest[0])
    assert [seqs(one) for one in pending.take_some(5)] == [[10, 20]]
    assert pending.take_some(1) == []


def test_what_has_waited_longest_as_it_is_comes_first():
    pending = Pending()
    for instance_id in (3, 1, 2):
        pending.put(view_set(instance_id, 10))
    pending.put(view_set(3, 10, 20))
    assert [one.instance_id for one in pending] == [1, 2, 3]
