"""Which full views show all candidates, and how their boxes are drawn."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.reasoning.numbered_boxes import covering_views, draw_boxes, is_visible

BOX = (10.0, 10.0, 50.0, 40.0)


def seen_in(*seqs):
    return tuple((seq, BOX) for seq in seqs)


@pytest.mark.parametrize(
    ("views", "most", "chosen"),
    [
        ([], 4, ()),
        ([seen_in()], 4, ()),
        ([seen_in(3, 5), seen_in(5), seen_in(8)], 4, (5, 8)),
        ([seen_in(3, 5), seen_in(3, 5)], 4, (3,)),  # both show both, 3 shows them better
        ([seen_in(5, 3), seen_in(5, 3)], 4, (5,)),
        ([seen_in(9), seen_in(1), seen_in(5)], 2, (9, 1)),  # the most probable come first
        ([seen_in(1), seen_in(2, 7), seen_in(7)], 1, (7,)),
        ([seen_in(4, 4)], 4, (4,)),
    ],
)
def test_few_views_show_many_things(views, most, chosen):
    assert covering_views(views, most) == chosen


ROOMS = st.lists(
    st.lists(st.integers(0, 9), max_size=4, unique=True).map(lambda seqs: seen_in(*seqs)),
    max_size=8,
)


@given(ROOMS)
def test_every_thing_that_has_a_view_is_shown(views):
    chosen = covering_views(views, 10)
    assert len(set(chosen)) == len(chosen)
    for of_thing in views:
        assert not of_thing or {seq for seq, _ in of_thing} & set(chosen)


@given(ROOMS)
def test_no_more_views_than_a_logarithm_over_the_fewest(views):
    things = [{seq for seq, _ in of_thing} for of_thing in views if of_thing]
    fewest = next(
        n
        for n in range(11)
        if any(
            all(set(some) & seqs for seqs in things)
            for some in itertools.combinations(range(10), n)
        )
    )
    assert len(covering_views(views, 10)) <= fewest * (1 + np.log(max(len(things), 1)))


def grey(height=120, width=160):
    return np.full((height, width, 3), 128, np.uint8)


def test_a_box_is_drawn_where_it_is_and_nowhere_else():
    rgb = grey(480, 640)
    marked = draw_boxes(rgb, {1: (200.0, 200.0, 300.0, 260.0)}, 1024)
    assert marked.boxes == {1: (200, 200, 300, 260)}
    assert (rgb == 128).all()  # the keyframe itself is left alone
    changed = (marked.rgb != 128).any(axis=2)
    assert changed[200:260, 200].all()
    assert not changed[210:250, 210:290].any()
    assert not changed[:150].any()
    assert not changed[:, 320:].any()


def test_a_large_picture_is_made_smaller_and_its_boxes_with_it():
    marked = draw_boxes(grey(1000, 2000), {3: (100.0, 200.0, 400.0, 600.0)}, 500)
    assert marked.rgb.shape == (250, 500, 3)
    assert marked.boxes == {3: (25, 50, 100, 150)}


def test_a_box_is_cut_to_the_picture():
    marked = draw_boxes(grey(), {1: (-30.0, -5.0, 500.0, 60.0)}, 1024)
    assert marked.boxes == {1: (0, 0, 160, 60)}


@pytest.mark.parametrize(
    "box", [(-30.0, 0.0, 0.0, 50.0), (160.0, 0.0, 180.0, 50.0), (5.0, 5.0, 5.2, 50.0)]
)
def test_a_box_that_cannot_be_seen_is_left_out(box):
    assert not is_visible(box, grey(), 1024)
    assert draw_boxes(grey(), {1: box}, 1024).boxes == {}


def test_numbers_of_boxes_in_one_place_do_not_cover_each_other():
    box = (60.0, 50.0, 120.0, 90.0)
    one = draw_boxes(grey(), {1: box}, 1024).rgb
    both = draw_boxes(grey(), {1: box, 2: box}, 1024).rgb
    tag = (slice(36, 50), slice(60, 68))  # above the corner, where the first number stands
    assert (one[tag] != 128).any()
    assert (one[tag] == both[tag]).all()


@given(
    st.dictionaries(
        st.integers(1, 12), st.tuples(*[st.floats(-50, 250, allow_nan=False)] * 4), max_size=5
    )
)
def test_any_boxes_can_be_drawn(boxes):
    marked = draw_boxes(grey(), boxes, 128)
    assert marked.rgb.shape == (96, 128, 3)
    assert set(marked.boxes) == {n for n, box in boxes.items() if is_visible(box, grey(), 128)}
    for x0, y0, x1, y1 in marked.boxes.values():
        assert 0 <= x0 < x1 <= 128
        assert 0 <= y0 < y1 <= 96
