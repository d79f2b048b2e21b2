"""Views are chosen for size, wholeness and different sides."""

import numpy as np
import pytest

from sceneq_core.views.choice import Candidates, ChoiceParams, choose

ORIGIN = np.zeros(3)


def candidates(visible_px, angles_deg, cut=()) -> Candidates:
    """Return keyframes 2 m from the origin at the given angles."""
    angle = np.radians(angles_deg)
    camera_world = 2 * np.stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))], axis=1)
    is_cut = np.isin(np.arange(len(angle)), cut)
    return Candidates(np.array(visible_px), is_cut, camera_world)


def chosen(*args, **params) -> list[int]:
    return choose(candidates(*args), ORIGIN, ChoiceParams(**params))


def test_the_largest_come_first():
    assert chosen([100, 300, 200], [0, 90, 180]) == [1, 2, 0]


def test_no_more_than_count():
    assert chosen([100, 300, 200], [0, 90, 180], count=2) == [1, 2]


def test_specks_are_no_views():
    assert chosen([63, 64], [0, 90], min_visible_px=64) == [1]
    assert chosen([10, 20], [0, 90]) == []


def test_a_whole_one_beats_a_larger_one_that_is_cut():
    assert chosen([300, 200], [0, 90], (0,)) == [1, 0]


def test_another_side_beats_a_larger_view_of_the_same():
    assert chosen([300, 290, 200], [0, 5, 90], count=2) == [0, 2]


def test_of_equal_views_the_oldest_wins():
    assert chosen([200, 200, 200], [0, 90, 180], count=2) == [0, 1]


def test_a_camera_inside_the_instance_has_no_direction():
    inside = Candidates(np.array([200]), np.array([False]), np.zeros((1, 3)))
    assert choose(inside, ORIGIN, ChoiceParams()) == [0]


@pytest.mark.parametrize(
    "bad", [{"count": 0}, {"min_visible_px": 0}, {"cut_weight": 1.5}, {"distinct_deg": -1.0}]
)
def test_parameters_are_checked(bad):
    with pytest.raises(ValueError, match=next(iter(bad))):
        ChoiceParams(**bad)
