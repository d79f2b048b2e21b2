"""Time in a scene to which robots come whose clocks do not agree."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.mapping.scene_clock import SceneClock
from sceneq_core.visits import seq_in_scene

S = 1_000_000_000


def times_s(*ticks):
    """Return the time after each (visit, stamp in s)."""
    clock = SceneClock()
    return [clock.tick(seq_in_scene(visit, 0), round(s * S)) / S for visit, s in ticks]


@given(st.lists(st.integers(0, 10**18), min_size=1))
def test_of_a_single_visit_it_is_the_largest_stamp_so_far(stamps):
    clock = SceneClock()
    times = [clock.tick(seq, stamp) for seq, stamp in enumerate(stamps)]
    assert times == [max(stamps[: i + 1]) for i in range(len(stamps))]


def test_it_goes_on_with_a_clock_that_is_behind_while_nobody_else_moves_it():
    assert times_s((0, 100), (1, 3), (1, 4), (1, 6.5)) == [100, 100, 101, 103.5]


def test_what_another_one_moved_is_not_counted_twice():
    live = [(visit, s + 9 * (not visit)) for s in range(4) for visit in (0, 1)]
    assert times_s(*live) == [9, 9, 10, 10, 11, 11, 12, 12]
    assert times_s((0, 9), (1, 0), (0, 10), (1, 1), (1, 2), (0, 11.5))[-3:] == [10, 11, 11.5]


def test_a_clock_that_is_ahead_takes_over():
    assert times_s((0, 1), (1, 50), (0, 2), (1, 51), (0, 3), (0, 4)) == [1, 50, 50, 51, 51, 52]


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 10**12)), min_size=1))
def test_it_never_runs_back_and_is_never_behind_a_stamp(ticks):
    clock, before = SceneClock(), 0
    for visit, stamp in ticks:
        now = clock.tick(seq_in_scene(visit, 0), stamp)
        assert now >= max(before, stamp)
        before = now


@given(st.lists(st.tuples(st.integers(0, 2), st.integers(1, 100)), min_size=1))
def test_robots_whose_clocks_are_off_do_not_make_it_run_fast(steps):
    """Each keyframe comes some time after the one before, of whatever robot."""
    off, clock, true = (0, 700, 30), SceneClock(), 0
    for visit, passed in steps:
        true += passed
        now = clock.tick(seq_in_scene(visit, 0), true + off[visit])
        assert now <= true + max(off)


@pytest.mark.parametrize("stamp_ns", [0, 1])
def test_it_begins_with_the_first_keyframe(stamp_ns):
    assert SceneClock().tick(0, stamp_ns) == stamp_ns
