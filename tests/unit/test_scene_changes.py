"""What became of things between two moments, by hand."""

import numpy as np
import pytest

from sceneq_core.evaluation.scene_changes import MIN_POINTS, Fate, Moment, fates

N = MIN_POINTS
CUP, LAMP, SOFA = 3, 5, 8


def ids(*blocks: tuple[int, int]) -> np.ndarray:
    """Return ``count`` times ``number`` for every block."""
    return np.repeat([number for number, _ in blocks], [count for _, count in blocks])


def judged(before: Moment, after: Moment, left, vacated=None, changed=()) -> dict[int, Fate]:
    everywhere = np.ones(len(before.thing), bool)
    vacated = everywhere if vacated is None else vacated
    return {fate.thing: fate for fate in fates(before, after, left, vacated, changed)}


def test_a_thing_that_stays_is_found_or_lost() -> None:
    before = Moment(ids((CUP, N), (LAMP, N), (SOFA, N)), ids((31, N), (51, N), (0, N)))
    after = Moment(ids((CUP, N), (LAMP, N), (SOFA, N)), ids((31, N), (0, N), (81, N)))
    fate = judged(before, after, after.instance)
    assert (fate[CUP].kind, fate[CUP].before, fate[CUP].after) == ("stayed", (31, 1.0), (31, 1.0))
    assert fate[CUP].is_judged
    assert fate[CUP].is_known
    assert fate[CUP].kept_id
    assert fate[LAMP].is_judged
    assert not fate[LAMP].is_known
    assert not fate[SOFA].is_judged  # it could not get lost: nobody had found it


def test_a_moved_thing_is_found_anew_and_leaves_no_ghost() -> None:
    before = Moment(ids((CUP, 2 * N)), ids((31, 2 * N)))
    after = Moment(ids((CUP, 2 * N)), ids((31, N), (0, N)))
    empty = np.zeros(2 * N, np.int64)
    fate = judged(before, after, empty, changed=[CUP])[CUP]
    assert (fate.kind, fate.after, fate.ghost) == ("moved", (31, 0.5), 0.0)
    assert fate.is_known
    assert fate.kept_id
    half = ids((31, N), (0, N))
    haunted = judged(before, after, half, changed=[CUP])[CUP]
    assert haunted.ghost == 0.5
    assert not haunted.is_known


def test_what_stands_on_the_former_place_now_is_no_ghost() -> None:
    before = Moment(ids((CUP, 2 * N)), ids((31, 2 * N)))
    nothing = Moment(np.zeros(0, np.int64), np.zeros(0, np.int64))
    left, vacated = ids((77, N), (0, N)), np.repeat([False, True], N)
    fate = judged(before, nothing, left, vacated, [CUP])[CUP]
    assert (fate.kind, fate.ghost, fate.is_known) == ("vanished", 0.0, True)
    assert not fate.kept_id


def test_a_thing_that_arrives_must_be_found() -> None:
    nothing = Moment(np.zeros(0, np.int64), np.zeros(0, np.int64))
    after = Moment(ids((CUP, N), (LAMP, N)), ids((31, N), (0, N)))
    fate = judged(nothing, after, nothing.instance, changed=[CUP, LAMP])
    assert (fate[CUP].kind, fate[CUP].is_known) == ("arrived", True)
    assert (fate[LAMP].kind, fate[LAMP].is_known) == ("arrived", False)


def test_a_thing_of_few_points_is_not_judged() -> None:
    before = Moment(ids((CUP, N - 1)), ids((31, N - 1)))
    assert judged(before, before, before.instance) == {}


def test_ids_of_another_length_are_refused() -> None:
    moment = Moment(ids((CUP, N)), ids((31, N)))
    with pytest.raises(ValueError, match="left, vacated: 1, 30 for 30"):
        fates(moment, moment, np.zeros(1, np.int64), np.zeros(N, bool), ())
