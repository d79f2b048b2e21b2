"""Superpoints into groups by agreement over views; evidence; which superpoints a frame shows."""

import numpy as np
import pytest

from sceneq_core.mapping.association import Association, AssociationParams
from sceneq_core.mapping.evidence import Evidence, agreement
from sceneq_core.mapping.superpoints import SuperpointChange
from sceneq_core.mapping.visibility import Visible, visible_superpoints

NO_IDS = np.zeros(0, np.int32)


def ids(*values):
    return np.array(values, np.int32)


class Film:
    """Feeds an association with views given as {superpoint: label}."""

    def __init__(self, superpoints=4, **params):
        self.association = Association(AssociationParams(**params))
        self.superpoints = superpoints
        self.keyframe = 0

    def show(self, labels, change=None):
        first = SuperpointChange(
            ids(*range(self.superpoints)), ids(*[-1] * self.superpoints), NO_IDS
        )
        none = SuperpointChange(NO_IDS, NO_IDS, NO_IDS)
        change = change or (none if self.keyframe else first)
        visible = Visible(ids(*labels), ids(*labels.values()), np.full(len(labels), 30, np.int64))
        result = self.association.update(change, visible, self.keyframe)
        self.keyframe += 1
        return result

    def groups(self):
        return self.association.of(np.arange(self.superpoints)).tolist()


def test_one_view_groups_by_segment():
    film = Film()
    change = film.show({0: 1, 1: 1, 2: 2, 3: -1})
    assert film.groups() == [0, 0, 1, -1]
    assert change.founded == ((0, -1), (1, -1))
    assert change.seen.tolist() == [0, 1]


def test_one_mask_over_two_objects_does_not_glue_them():
    film = Film()
    for labels in ((1, 1, 2, 2), (3, 3, 3, 3), (2, 2, 1, 1), (4, 4, 5, 5)):
        film.show(dict(enumerate(labels)))
    assert film.groups() == [0, 0, 1, 1]


def test_one_split_mask_does_not_shatter_an_object():
    film = Film()
    for labels in ((1, 1, 1, 1), (2, 2, 3, 3), (1, 1, 1, 1), (7, 7, 7, 7)):
        film.show(dict(enumerate(labels)))
    assert film.groups() == [0, 0, 0, 0]


def test_a_first_view_that_glued_two_objects_is_corrected():
    film = Film()
    film.show({0: 1, 1: 1, 2: 1, 3: 1})
    for _ in range(3):
        last = film.show({0: 1, 1: 1, 2: 2, 3: 2})
    groups = film.groups()
    assert groups[0] == groups[1] == 0
    assert groups[2] == groups[3] != 0
    assert last.merged == ()


def test_a_first_view_that_split_an_object_is_corrected_by_a_merge():
    film = Film()
    film.show({0: 1, 1: 1, 2: 2, 3: 2})
    merged = [film.show({0: 1, 1: 1, 2: 1, 3: 1}).merged for _ in range(4)]
    assert len(set(film.groups())) == 1
    assert sum(len(pairs) for pairs in merged) <= 1


def test_a_split_off_superpoint_inherits_group_and_evidence():
    film = Film(superpoints=2)
    for _ in range(3):
        film.show({0: 1, 1: 2})
    film.superpoints = 3
    film.show({0: 1, 1: 2, 2: 1}, SuperpointChange(ids(2), ids(0), NO_IDS))
    assert film.groups() == [0, 1, 0]


def test_an_emptied_group_is_reported_and_its_number_given_again():
    film = Film(superpoints=2)
    film.show({0: 1, 1: 2})
    change = film.show({0: 1}, SuperpointChange(NO_IDS, NO_IDS, ids(1)))
    assert change.changed.tolist() == [0, 1]
    assert film.groups() == [0, -1]
    assert film.show({1: 5}, SuperpointChange(ids(1), ids(-1), NO_IDS)).founded == ((1, -1),)


def test_too_few_pixels_found_nothing():
    film = Film(min_pixels=100)
    assert film.show({0: 1, 1: 2}).founded == ()
    assert film.groups() == [-1] * 4


def test_agreement_is_shy_with_little_evidence():
    same, common = np.array([0, 0, 1, 9]), np.array([0, 1, 1, 9])
    assert agreement(same, common) == pytest.approx([0.5, 0.25, 0.75, 0.95])


def test_only_views_of_both_with_a_segment_are_common():
    evidence = Evidence(views=4)
    evidence.reserve(2)
    evidence.record(ids(0, 1), 0, ids(5, 5))
    evidence.record(ids(0, 1), 1, ids(6, 7))
    evidence.record(ids(0, 1), 2, ids(8, -1))
    evidence.record(ids(0), 3, ids(9))
    same, common = evidence.compare(ids(0), evidence, ids(1))
    assert (same.tolist(), common.tolist()) == ([1], [2])


def test_old_views_make_room_and_never_match_new_ones():
    evidence = Evidence(views=2)
    evidence.reserve(2)
    evidence.record(ids(0, 1), 0, ids(5, 5))
    evidence.record(ids(0), 2, ids(5))
    same, common = evidence.compare(ids(0), evidence, ids(1))
    assert (same.tolist(), common.tolist()) == ([0], [0])


def test_the_majority_of_the_members_stands_for_the_group():
    members, group = Evidence(views=2), Evidence(views=2)
    members.reserve(3)
    group.reserve(1)
    members.record(ids(0, 1, 2), 0, ids(5, 6, 6))
    members.record(ids(0, 1), 1, ids(8, 7))
    members.record(ids(2), 3, ids(9))
    group.take_majority(ids(0), members, ids(0, 1, 2), ids(0, 0, 0))
    same, common = group.compare(ids(0, 0, 0), members, ids(0, 1, 2))
    assert (same.tolist(), common.tolist()) == ([0, 1, 2], [1, 1, 2])


def test_a_visible_superpoint_takes_the_segment_that_covers_more_than_half():
    superpoint = ids(0, 0, 0, 1, 1, 1, 2, 2, -1)
    label = np.array([4, 4, 0, 4, 5, 0, 7, 7, 9], np.uint16)
    visible = visible_superpoints(superpoint, label, min_pixels=3)
    assert visible.superpoint_id.tolist() == [0, 1]
    assert visible.label.tolist() == [4, -1]
    assert visible.pixels.tolist() == [3, 3]


@pytest.mark.parametrize(
    ("values", "field"),
    [
        ({"views": 0}, "views"),
        ({"min_agreement": 1.0}, "min_agreement"),
        ({"hold": 0.5}, "hold"),
        ({"merge_agreement": 0.4}, "merge_agreement"),
        ({"min_common_views": 0}, "min_common_views"),
        ({"min_pixels": 0}, "min_pixels"),
    ],
)
def test_a_bad_parameter_is_named(values, field):
    with pytest.raises(ValueError, match=f"^{field}: "):
        AssociationParams(**values)
