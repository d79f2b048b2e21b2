"""Groups that are merged and taken out again by one keyframe stay who they are."""

import numpy as np

from sceneq_core.mapping.group_change import Changes


def groups(*numbers: int) -> np.ndarray:
    return np.array(numbers, np.int32)


def changed(founded=(), merged=()) -> Changes:
    changes = Changes()
    changes.founded, changes.merged = tuple(founded), tuple(merged)
    return changes


def test_what_was_merged_and_is_apart_again_is_the_group_it_was() -> None:
    changes = changed(founded=[(9, 2)], merged=[(7, 2)])
    before, after = groups(7, 7, 7, 2, -1), groups(9, 9, 2, 2, 9, 9)
    assert changes.continued(before, after) == ((9, 7),)
    changes.resume(9, 7)
    assert changes.founded == ()
    assert changes.merged == ()
    assert changes.groups().tolist() == [7, 9]


def test_a_part_of_another_group_is_a_new_one() -> None:
    changes = changed(founded=[(9, 2)], merged=[(7, 2)])
    assert changes.continued(groups(2, 2, 7, 7), groups(9, 9, 2, 2)) == ()
    assert changes.continued(groups(2, 7), groups(9, 9)) == ()  # as much of the one as of the other


def test_a_group_that_lives_on_gives_its_number_to_nobody() -> None:
    changes = changed(founded=[(9, 7)])
    assert changes.continued(groups(7, 7, 7), groups(9, 9, 7)) == ()


def test_of_two_parts_the_larger_goes_on_and_the_other_came_out_of_it() -> None:
    changes = changed(founded=[(8, 2), (9, 8)], merged=[(7, 2), (5, 8)])
    before, after = groups(7, 7, 7, 5), groups(8, 8, 9, 8)
    assert changes.continued(before, after) == ((8, 7),)
    changes.resume(8, 7)
    assert changes.founded == ((9, 7),)
    assert changes.merged == ((5, 7),)
