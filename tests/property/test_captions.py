"""Captions never overlap, whatever is to be written where."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_core.picture.captions import GAP_PX, Caption, Placed, Rect, place

SIZE = (400, 300)


@st.composite
def captions(draw: st.DrawFn) -> Caption:
    width, height = draw(st.integers(8, 160)), draw(st.integers(8, 24))
    anchor = draw(st.integers(0, SIZE[0] - 1)), draw(st.integers(0, SIZE[1] - 1))
    reach = draw(st.sampled_from([0, 30]))
    return Caption(draw(st.integers(1, 99)), (width, height), anchor, draw(st.booleans()), reach)


def apart(a: Rect, b: Rect) -> bool:
    level = a.left >= b.right + GAP_PX or b.left >= a.right + GAP_PX
    return level or a.top >= b.bottom + GAP_PX or b.top >= a.bottom + GAP_PX


def points_of_leader(placed: Placed) -> np.ndarray:
    share = np.linspace(0, 1, 400)[:, None]
    assert placed.leader is not None
    return np.array(placed.caption.anchor) * (1 - share) + np.array(placed.leader) * share


@given(st.lists(captions(), max_size=25))
@settings(max_examples=60, deadline=None)
def test_texts_stay_inside_and_apart_and_no_leader_runs_through_one(given: list[Caption]) -> None:
    taken = [Rect(0, 250, 120, 300)]
    placed = place(given, SIZE, taken)
    rects = [*taken, *(one.rect for one in placed)]
    for number, rect in enumerate(rects):
        assert 0 <= rect.left < rect.right <= SIZE[0]
        assert 0 <= rect.top < rect.bottom <= SIZE[1]
        assert all(apart(rect, other) for other in rects[:number])
    for one in placed:
        if one.leader is None:
            continue
        for rect in rects:
            inner = points_of_leader(one) - [rect.left, rect.top]
            size = np.array([rect.right - rect.left, rect.bottom - rect.top])
            assert rect == one.rect or not ((inner > 0.5) & (inner < size - 0.5)).all(axis=1).any()


@given(st.lists(captions(), min_size=1, max_size=12))
@settings(max_examples=30, deadline=None)
def test_later_captions_do_not_drive_out_earlier_ones(given: list[Caption]) -> None:
    early, all_placed = place(given[:-1], SIZE), place(given, SIZE)
    assert [one.caption for one in early] == [one.caption for one in all_placed][: len(early)]


def test_what_does_not_fit_is_left_out() -> None:
    wide = [Caption(n, (390, 100), (200.0, 150.0), False) for n in range(5)]
    assert 0 < len(place(wide, SIZE)) < 5


def test_a_text_on_its_thing_has_no_leader_and_others_keep_their_distance() -> None:
    on_it, beside = place(
        [Caption(1, (20, 10), (50.0, 50.0), True), Caption(2, (20, 10), (90.0, 50.0), False, 30)],
        SIZE,
    )
    assert on_it.leader is None
    assert on_it.rect == Rect(40, 45, 60, 55)
    assert beside.leader is not None
    assert np.hypot(beside.leader[0] - 90, beside.leader[1] - 50) >= 30
