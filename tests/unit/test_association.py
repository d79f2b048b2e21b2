"""Superpoints into groups by agreement over views; which superpoints a frame shows."""

import numpy as np
import pytest

from sceneq_core.mapping.association_params import AssociationParams
from sceneq_core.mapping.contacts import NO_CONTACTS
from sceneq_core.mapping.superpoints import SuperpointChange
from sceneq_core.mapping.visibility import NOTHING_VISIBLE, visible_superpoints

from support.film import NO_IDS, Film, coloured, ids, touching


def test_one_view_groups_by_segment():
    film = Film()
    change = film.show({0: 1, 1: 1, 2: 2, 3: -1})
    assert film.groups() == [0, 0, 1, -1]
    assert change.founded == ((0, -1), (1, -1))
    assert change.seen.tolist() == [0, 1]
    assert change.changed.tolist() == [0, 1]


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


def test_masks_that_fall_into_ever_other_pieces_do_not_shatter_an_object():
    film = Film(superpoints=6)
    for labels in ("111122", "122222", "111111", "112222", "111112", "111111"):
        film.show(dict(enumerate(map(int, labels))))
    assert len(film.partition()) == 1


def test_a_first_view_that_glued_two_objects_is_corrected():
    film = Film()
    film.show({0: 1, 1: 1, 2: 1, 3: 1})
    changes = [film.show({0: 1, 1: 1, 2: 2, 3: 2}) for _ in range(3)]
    groups = film.groups()
    assert groups[0] == groups[1]
    assert groups[2] == groups[3] != groups[0]
    assert [pair for change in changes for pair in change.founded] == [(1, 0)]
    assert changes[-1].merged == ()


def test_two_objects_that_were_glued_for_long_come_apart():
    film = Film()
    for _ in range(6):
        film.show({0: 1, 1: 1, 2: 1, 3: 1})
    for _ in range(20):
        film.show({0: 1, 1: 1, 2: 2, 3: 2})
    assert film.partition() == {frozenset({0, 1}), frozenset({2, 3})}


def test_a_first_view_that_split_an_object_is_corrected_by_one_merge():
    film = Film()
    film.show({0: 1, 1: 1, 2: 2, 3: 2})
    merged = [film.show({0: 1, 1: 1, 2: 1, 3: 1}).merged for _ in range(4)]
    assert len(film.partition()) == 1
    assert sum(len(pairs) for pairs in merged) == 1


def test_two_groups_of_one_view_do_not_merge_by_the_next_alone():
    film = Film(min_common_views=2)
    film.show({0: 1, 1: 1})
    film.show({2: 1, 3: 1})
    assert film.show({0: 1, 1: 1, 2: 1, 3: 1}).merged == ()
    assert film.show({0: 1, 1: 1, 2: 1, 3: 1}).merged == ((1, 0),)


ONE_BORDER = touching((1, 2, 10, 9))
"""Superpoints 1 and 2 touch, and the surface goes on along nine tenths of their border."""
CORNER = touching((1, 2, 10, 1))


ONE_STUFF = coloured(s0=20, s1=20, s2=20, s3=20)
TWO_STUFFS = coloured(s0=20, s1=20, s2=40, s3=40)


def halves_seen_apart_and_then_as_one(contacts, colours):
    film = Film(contact_views=0.0)
    film.show({0: 1, 1: 1, 2: 2, 3: 2}, contacts=contacts, colours=colours)
    film.show({0: 1, 1: 1, 2: 1, 3: 1})
    return film


@pytest.mark.parametrize(
    ("contacts", "colours", "merged"),
    [
        (ONE_BORDER, ONE_STUFF, ((1, 0),)),
        (ONE_BORDER, TWO_STUFFS, ()),
        (CORNER, ONE_STUFF, ()),
        (NO_CONTACTS, ONE_STUFF, ()),
    ],
)
def test_after_one_view_of_two_the_looks_decide_once_both_are_out_of_view(
    contacts, colours, merged
):
    # In view (1 + 1/2) / (2 + 1) = 0.5 is not above tau_merge. Three views more say with a kinship
    # of the root of 0.9 times 1: (1 + 2.85 + 1/2) / (2 + 3 + 1) = 0.72; with the root of 0.1: 0.41.
    film = halves_seen_apart_and_then_as_one(contacts, colours)
    assert film.groups() == [0, 0, 1, 1]
    assert film.show({}).merged == merged


def test_one_view_that_shows_two_pieces_of_one_stuff_and_surface_is_overruled():
    # (0 + 2.85 + 1/2) / (1 + 3 + 1) = 0.67; two views more that show them apart: 0.48.
    apart = {0: 1, 1: 1, 2: 2, 3: 2}
    film = Film()
    film.show(apart, contacts=ONE_BORDER, colours=ONE_STUFF)
    assert film.show({}).merged == ((1, 0),)
    film = Film()
    film.show(apart, contacts=ONE_BORDER, colours=ONE_STUFF)
    film.show(apart)
    film.show(apart)
    assert film.show({}).merged == ()
    film = Film()
    film.show(apart, contacts=ONE_BORDER)
    assert film.show({}).merged == ()


def test_a_part_is_let_go_later_where_it_looks_like_its_group():
    def views_until_apart(contacts, colours):
        film = Film()
        film.show({0: 1, 1: 1, 2: 1, 3: 1}, contacts=contacts, colours=colours)
        for view in range(1, 9):
            if film.show({0: 1, 1: 1, 2: 2, 3: 2}).founded:
                return view
        return None

    # tau_detach is 0.45. Superpoints disagree, (1 + 1/2) / (3 + 1) = 0.375, after two views; their
    # part, with a kinship of 0.95, after five: (1 + 2.85 + 1/2) / (6 + 3 + 1) = 0.435.
    assert views_until_apart(CORNER, TWO_STUFFS) == 2
    assert views_until_apart(ONE_BORDER, ONE_STUFF) == 5


def test_a_superpoint_that_is_out_of_view_goes_where_most_of_its_border_does():
    film = Film(superpoints=5)
    around = touching((0, 4, 2, 2), (2, 4, 8, 8))
    film.show({0: 1, 1: 1, 2: 2, 3: 2, 4: 1}, contacts=around)
    film.show({0: 1, 1: 1, 2: 2, 3: 2, 4: 2})
    assert film.groups()[4] == film.groups()[0]
    film.show({})
    assert film.groups()[4] == film.groups()[2]


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


def test_groups_found_in_one_place_unite_unless_a_view_tells_them_apart():
    film = Film(superpoints=6)
    film.show({0: 1, 1: 2})
    film.show({2: 1, 3: 1})
    assert film.association.unite(ids(0, 0), ids(1, 2)) == ((0, 2),)
    assert film.groups() == [2, 1, 2, 2, -1, -1]


def test_a_dissolved_group_starts_anew():
    film = Film()
    for _ in range(4):
        film.show({0: 1, 1: 1, 2: 2, 3: 2})
    film.association.dissolve(ids(1))
    assert film.groups() == [0, 0, -1, -1]
    film.show({0: 1, 1: 1, 2: 2, 3: 3})
    assert film.groups()[2] != film.groups()[3]


def test_external_masks_found_groups_that_the_views_can_refute():
    film = Film()

    def entering():
        every = ids(0, 1, 2, 3)
        return film.association.found(every, ids(7, 7, 9, -1), ids(-1, -1, -1, -1), views=3)

    change = film.show({}, entering=entering)
    assert film.groups() == [0, 0, 1, -1]
    assert change.founded == ((0, -1), (1, -1))
    film.show({0: 1, 1: 2, 2: 3})
    assert film.groups() == [0, 0, 1, -1]
    for _ in range(8):
        film.show({0: 1, 1: 2, 2: 3})
    assert len(film.partition()) == 3


def test_nothing_visible_changes_nothing():
    film = Film()
    film.show({0: 1, 1: 1, 2: 2, 3: 2})
    change = film.association.update(SuperpointChange(NO_IDS, NO_IDS, NO_IDS), NOTHING_VISIBLE, 1)
    assert (change.changed.tolist(), change.seen.tolist()) == ([], [])


def test_a_visible_superpoint_takes_the_segment_that_shows_most_of_it():
    superpoint = ids(0, 0, 0, 0, 1, 1, 1, 2, 2, -1, 3, 3, 3)
    label = np.array([4, 4, 0, 0, 4, 5, 0, 7, 7, 9, 0, 0, 0], np.uint16)
    visible = visible_superpoints(superpoint, label, min_pixels=3)
    assert visible.superpoint_id.tolist() == [0, 1, 3]
    assert visible.label.tolist() == [4, 4, -1]
    assert visible.pixels.tolist() == [4, 3, 3]


@pytest.mark.parametrize(
    ("values", "field"),
    [
        ({"views": 0}, "views"),
        ({"top_views": 0}, "top_views"),
        ({"min_pixels": 0}, "min_pixels"),
        ({"min_score": 1.0}, "min_score"),
        ({"hold": 0.0}, "hold"),
        ({"vote_weight": 1.5}, "vote_weight"),
        ({"tau_detach": 0.5}, "tau_detach"),
        ({"tau_merge": 1.0}, "tau_merge"),
        ({"min_common_views": 0}, "min_common_views"),
        ({"contact_views": -1.0}, "contact_views"),
        ({"max_rounds": 0}, "max_rounds"),
    ],
)
def test_a_bad_parameter_is_named(values, field):
    with pytest.raises(ValueError, match=f"^{field}: "):
        AssociationParams(**values)
