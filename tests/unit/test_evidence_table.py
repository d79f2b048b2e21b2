"""The evidence table keeps the latest views of every superpoint."""

import numpy as np

from sceneq_core.mapping.evidence import Evidence
from sceneq_core.mapping.tally import Tally

from support.film import ids


def px(*values):
    return np.array(values, np.int64)


def table(views):
    evidence = Evidence(views)
    evidence.reserve(3)
    return evidence


def test_the_oldest_view_makes_room_and_is_handed_back():
    evidence = table(views=2)
    for segment, old in ((5, 0), (6, 0), (7, 5), (8, 6)):
        oldest, pixels = evidence.record(ids(1), ids(segment), px(10 * segment))
        assert (oldest.tolist(), pixels.tolist()) == ([old], [10 * old])
    assert sorted(evidence.segments(ids(1))[0].tolist()) == [7, 8]
    segment, pixels = evidence.latest(ids(1, 0))
    assert (segment.tolist(), pixels.tolist()) == ([8, 0], [80, 0])


def test_entries_name_the_row_that_was_asked_for():
    evidence = table(views=3)
    evidence.record(ids(0, 2), ids(5, 6), px(1, 2))
    evidence.record(ids(2), ids(9), px(3))
    entries = evidence.entries(ids(2, 1, 0))
    assert entries.row.tolist() == [0, 0, 2]
    assert entries.segment.tolist() == [6, 9, 5]
    assert entries.pixels.tolist() == [2, 3, 1]


def test_a_copy_goes_its_own_way():
    evidence = table(views=2)
    evidence.record(ids(0), ids(5), px(1))
    evidence.copy(ids(1), ids(0))
    evidence.record(ids(1), ids(6), px(1))
    evidence.forget(ids(0))
    assert evidence.segments(ids(0, 1)).tolist() == [[0, 0], [5, 6]]


def test_a_tally_drops_what_adds_up_to_nothing():
    tally = Tally()
    tally.add(px(7, 3, 7), px(1, 2, 4))
    tally.add(px(5, 3), px(6, -2))
    assert tally.key.tolist() == [5, 7]
    assert tally.total.tolist() == [6, 5]
    tally.add(px(), px())
    assert tally.key.tolist() == [5, 7]
