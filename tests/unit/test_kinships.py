"""What is known of pairs of groups is asked for again only when one of them changed."""

import numpy as np

from sceneq_core.mapping.kinships import Kinships
from sceneq_core.mapping.neighbourhood import Neighbourhood
from sceneq_core.mapping.visibility import Visible

from support.film import NO_CHANGE, NO_IDS, coloured, ids, touching

NONE_SEEN = np.zeros(0, np.int64)
OUT_OF_VIEW = np.zeros(4, np.bool_)


def chain():
    """Return the neighbourhood of superpoints 0 to 3 in a row, all of one colour."""
    neighbourhood = Neighbourhood()
    contacts = touching((0, 1, 10, 10), (1, 2, 10, 10), (2, 3, 10, 10))
    colours = coloured(s0=9, s1=9, s2=9, s3=9)
    seen = Visible(NO_IDS, NO_IDS, NONE_SEEN, contacts, colours)
    neighbourhood.follow(NO_CHANGE, seen, ids(-1, -1, -1, -1))
    return neighbourhood


def pairs(packed):
    return [(int(pair >> 32), int(pair & 0xFFFFFFFF)) for pair in packed]


def test_meetings_follow_the_groups_that_changed():
    neighbourhood, kinships = chain(), Kinships()
    borders = neighbourhood.borders(ids(0, 1, 1, 2))
    kinships.forget(ids(0, 1, 2))
    assert pairs(kinships.meeting(borders, OUT_OF_VIEW)) == [(0, 1), (1, 2)]
    moved = neighbourhood.borders(ids(0, 1, 2, 2))
    kinships.forget(ids(1, 2, -1))
    assert pairs(kinships.meeting(moved, OUT_OF_VIEW)) == [(0, 1), (1, 2)]
    kinships.forget(ids(0, 1))
    assert pairs(kinships.meeting(neighbourhood.borders(ids(1, 1, 2, 2)), OUT_OF_VIEW)) == [(1, 2)]


def test_meetings_of_what_is_in_view_wait_until_it_has_left():
    neighbourhood, kinships = chain(), Kinships()
    borders = neighbourhood.borders(ids(0, 1, 2, 3))
    kinships.forget(ids(0, 1, 2, 3))
    in_view = np.array([False, True, False, False])
    assert pairs(kinships.meeting(borders, in_view)) == [(2, 3)]
    assert pairs(kinships.meeting(borders, OUT_OF_VIEW)) == [(0, 1), (1, 2), (2, 3)]
    assert pairs(kinships.meeting(borders, in_view)) == [(2, 3)]
    kinships.forget(ids(1))
    assert pairs(kinships.meeting(borders, OUT_OF_VIEW)) == [(0, 1), (1, 2), (2, 3)]


def test_kinship_is_remembered_until_a_group_changes():
    neighbourhood, kinships = chain(), Kinships()
    borders = neighbourhood.borders(ids(0, 1, 2, 3))
    kinships.forget(ids(0, 1, 2, 3))
    first, second = np.array([0, 2]), np.array([1, 3])
    np.testing.assert_allclose(kinships.of(borders, first, second), [1.0, 1.0])
    other = neighbourhood.borders(ids(0, 1, 2, -1))
    np.testing.assert_allclose(kinships.of(other, first, second), [1.0, 1.0])
    kinships.forget(ids(3))
    np.testing.assert_allclose(kinships.of(other, first, second), [1.0, 0.0])
    assert kinships.of(other, first[:0], second[:0]).tolist() == []
    np.testing.assert_allclose(kinships.of(other, first, second), [1.0, 0.0])
