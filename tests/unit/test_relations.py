"""Relations between boxes: which way they point, and that they survive a tilted world."""

import numpy as np
import pytest

from sceneq_core.reasoning.relations import RELATIONS, Pair, RelationParams
from sceneq_core.reasoning.superlatives import probability_of_rank
from sceneq_core.reasoning.upright import UprightBox, distance, overlap, upright_axes

PARAMS = RelationParams()
TABLE = UprightBox(np.array([0.0, 0.0, 0.0]), np.array([1.0, 1.0, 0.7]))


def box(low, high):
    return UprightBox(np.array(low, float), np.array(high, float))


def score(relation, target, anchor=TABLE):
    offset = target.centre - anchor.centre
    return RELATIONS[relation](Pair(target, anchor, offset), PARAMS)


ON_TABLE = box((0.4, 0.4, 0.7), (0.5, 0.5, 0.8))
UNDER_TABLE = box((0.4, 0.4, 0.0), (0.6, 0.6, 0.3))
BESIDE_TABLE = box((1.2, 0.4, 0.0), (1.4, 0.6, 0.4))
ABOVE_TABLE = box((0.3, 0.3, 1.5), (0.7, 0.7, 1.8))
FAR = box((5.0, 5.0, 0.0), (5.3, 5.3, 0.5))
PLACED = {
    "on": ON_TABLE,
    "under": UNDER_TABLE,
    "next_to": BESIDE_TABLE,
    "above": ABOVE_TABLE,
}


@pytest.mark.parametrize("relation", sorted(PLACED))
def test_each_relation_likes_its_own_place_best(relation):
    scores = {name: score(relation, target) for name, target in PLACED.items()}
    assert max(scores, key=scores.get) == relation
    assert scores[relation] > 0.5


@pytest.mark.parametrize("relation", sorted(set(RELATIONS) - {"far_from"}))
def test_no_relation_reaches_across_the_house(relation):
    assert score(relation, FAR) < 0.05


def test_a_cushion_is_on_the_sofa_although_the_back_is_higher():
    sofa = box((0, 0, 0), (2, 0.9, 0.8))
    assert score("on", box((0.2, 0.3, 0.42), (0.6, 0.6, 0.75)), sofa) > 0.5


def test_a_picture_is_on_the_wall_it_touches():
    wall = box((0, 3, 0), (4, 3.1, 2.5))
    assert score("on", box((1, 2.96, 1.4), (1.6, 3.0, 1.9)), wall) > 0.5
    assert score("on", box((1, 2.0, 1.4), (1.6, 2.1, 1.9)), wall) < 0.05


def test_inside_is_the_share_in_the_box():
    drawer = box((0, 0, 0), (1, 1, 1))
    assert score("in", box((0.2, 0.2, 0.2), (0.4, 0.4, 0.4)), drawer) == pytest.approx(1.0)
    assert score("in", box((0.9, 0.2, 0.2), (1.1, 0.4, 0.4)), drawer) == pytest.approx(0.5)


def test_left_is_not_right_and_front_is_not_behind():
    left = Pair(BESIDE_TABLE, TABLE, np.array([-0.8, 0.0, 0.0]))
    assert RELATIONS["left_of"](left, PARAMS) > 0.8
    assert RELATIONS["right_of"](left, PARAMS) == 0.0
    front = Pair(BESIDE_TABLE, TABLE, np.array([0.0, -0.8, 0.0]))
    assert RELATIONS["in_front_of"](front, PARAMS) > 0.8
    assert RELATIONS["behind"](front, PARAMS) == 0.0


def test_distance_and_overlap_of_boxes():
    assert distance(TABLE, box((1.3, 1.4, 0), (2, 2, 1))) == pytest.approx(0.5)
    assert overlap(ON_TABLE, TABLE, slice(0, 2), 0.05) == pytest.approx(1.0)
    flat = box((0.95, 0.0, 0.0), (0.95, 1.0, 1.0))
    assert overlap(flat, TABLE, slice(0, 1), 0.1) == pytest.approx(1.0)


def test_upright_axes_stand_on_the_floor_along_the_box():
    angle = np.deg2rad(30)
    T_world_box = np.eye(4)
    T_world_box[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    axes = upright_axes(T_world_box, np.array([0.0, 0.0, 2.0]))
    assert axes @ axes.T == pytest.approx(np.eye(3))
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert axes[2] == pytest.approx([0, 0, 1])
    assert abs(axes[0] @ T_world_box[:3, :3]).max() == pytest.approx(1.0)


def test_the_first_of_equals_is_undecided():
    first = probability_of_rank(np.ones(3), np.zeros(3), 0.1)
    assert first == pytest.approx([0.25] * 3)


def test_a_doubtful_nearer_thing_does_not_beat_a_certain_one():
    first = probability_of_rank(np.array([0.1, 1.0]), np.array([1.0, 2.0]), 0.05)
    assert first == pytest.approx([0.1, 0.9])


@pytest.mark.parametrize("name", ["contact_m", "reach_m", "near_m", "thinnest_m"])
def test_scales_must_be_positive(name):
    with pytest.raises(ValueError, match=f"{name}: must be positive, got 0.0"):
        RelationParams(**{name: 0.0})
