"""Which colour goes with which depth."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.ingest.synchronizer import Synced, Synchronizer, SyncParams, Unmatched

MS = 1_000_000


def sync(*streams, tolerance_s=0.02, capacity=16):
    return Synchronizer(SyncParams(tolerance_s, capacity), *(streams or ("colour", "depth")))


def fed(joiner, *arrivals):
    """Feed (stream, milliseconds); return what is settled, items being the milliseconds."""
    settled = []
    for stream, ms in arrivals:
        settled += joiner.add(stream, ms * MS, ms)
    return settled


def pairs(settled):
    return [s.items for s in settled if isinstance(s, Synced)]


def test_equal_stamps_are_joined_at_once():
    assert pairs(fed(sync(), ("colour", 100), ("depth", 100))) == [(100, 100)]
    assert pairs(fed(sync(), ("depth", 100), ("colour", 100))) == [(100, 100)]


def test_the_nearest_is_taken_not_the_first():
    arrivals = [("depth", 85), ("colour", 100), ("depth", 98), ("depth", 112)]
    settled = fed(sync(), *arrivals)
    assert pairs(settled) == [(100, 98)]
    assert Unmatched("depth", 85 * MS, 0.015) in settled


def test_nothing_is_settled_while_something_nearer_may_come():
    joiner = sync()
    assert fed(joiner, ("depth", 90), ("colour", 100)) == []
    assert pairs(fed(joiner, ("depth", 101))) == [(100, 101)]


def test_beyond_the_tolerance_nothing_is_joined():
    settled = fed(sync(), ("colour", 100), ("depth", 121), ("colour", 133))
    assert settled == [Unmatched("colour", 100 * MS, 0.021)]
    assert pairs(fed(sync(), ("colour", 100), ("depth", 120))) == [(100, 120)]


def test_each_item_is_used_once():
    settled = fed(sync(), ("colour", 100), ("colour", 105), ("depth", 102), ("depth", 150))
    assert pairs(settled) == [(100, 102)]
    assert [s.stamp_ns for s in settled if isinstance(s, Unmatched)] == [105 * MS]


def test_three_streams_need_all_three():
    joiner = sync("colour", "depth", "pose")
    assert fed(joiner, ("colour", 100), ("depth", 101)) == []
    assert pairs(fed(joiner, ("pose", 103))) == [(100, 101, 103)]


def test_what_waits_too_long_goes_alone():
    settled = fed(sync(capacity=3), *(("colour", ms) for ms in range(0, 500, 100)))
    assert settled == [Unmatched("colour", 0, None), Unmatched("colour", 100 * MS, None)]


def test_stamps_must_grow():
    joiner = sync()
    fed(joiner, ("colour", 100))
    for ms in (100, 50):
        with pytest.raises(ValueError, match="colour: stamp goes back by"):
            joiner.add("colour", ms * MS, ms)
    assert joiner.clear() == 1
    assert pairs(fed(joiner, ("colour", 50), ("depth", 50))) == [(50, 50)]


def test_what_waits_for_something_nearer_is_joined_when_nothing_comes():
    joiner = sync()
    assert pairs(fed(joiner, ("depth", 95), ("colour", 100), ("colour", 200))) == []
    assert pairs(joiner.flush()) == [(100, 95)]
    assert joiner.flush() == []
    assert pairs(fed(joiner, ("depth", 201))) == [(200, 201)]


def test_bad_parameters():
    with pytest.raises(ValueError, match="tolerance_s"):
        SyncParams(tolerance_s=-1)
    with pytest.raises(ValueError, match="capacity"):
        SyncParams(capacity=0)
    with pytest.raises(ValueError, match="streams"):
        sync("colour")


STAMPS = st.lists(st.integers(0, 400), min_size=1, max_size=12, unique=True).map(sorted)


@given(STAMPS, STAMPS, st.randoms(use_true_random=False))
def test_the_order_between_streams_does_not_matter(colour, depth, random):
    # Beyond the last stamp of both, so that everything is settled.
    colour, depth = [*colour, 1000], [*depth, 1000]
    one_by_one = [("colour", c) for c in colour], [("depth", d) for d in depth]
    mixed, queues = [], [list(q) for q in one_by_one]
    while any(queues):
        mixed.append(random.choice([q for q in queues if q]).pop(0))
    expected = pairs(fed(sync(), *one_by_one[0], *one_by_one[1]))
    found = pairs(fed(sync(), *mixed))
    assert found == expected
    assert all(abs(c - d) <= 20 for c, d in found)
    assert len({d for _, d in found}) == len(found)
    assert (1000, 1000) in found
    assert (np.diff([c for c, _ in found]) > 0).all()
