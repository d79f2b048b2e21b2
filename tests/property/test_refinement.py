"""Refinement: a fixed point, the same whether it looks at what changed or at everything."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_core.mapping.coverage import Coverage
from sceneq_core.mapping.superpoints import SuperpointChange

from support.film import NO_IDS, Film, coloured, ids, touching

SUPERPOINTS = 12
OBJECTS = np.repeat(np.arange(3), 4)


def imperfect_view(rng, split=0.25, merge=0.15):
    """Return a view of three objects, some out of sight, in pieces or glued to the next one."""
    label = 10 * OBJECTS + 1
    for number in range(3):
        inside = np.flatnonzero(number == OBJECTS)
        if rng.random() < split:
            label[inside[rng.integers(1, 4) :]] += 1
        if rng.random() < merge:
            label[inside] = label[(inside + 4) % SUPERPOINTS]
    seen = rng.random(SUPERPOINTS) < 0.8
    return {s: int(label[s]) for s in range(SUPERPOINTS) if seen[s]}


def noise(rng):
    labels = rng.integers(-1, 4, SUPERPOINTS)
    return {s: int(labels[s]) or -1 for s in range(SUPERPOINTS) if rng.random() < 0.7}


def replaced(rng):
    """Return a change in which a superpoint ends and comes again as a part of another."""
    gone, parent = rng.choice(SUPERPOINTS, 2, replace=False)
    return (
        SuperpointChange(NO_IDS, NO_IDS, ids(gone)),
        SuperpointChange(ids(gone), ids(parent), NO_IDS),
    )


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10_000), views=st.integers(1, 40))
def test_a_full_pass_after_a_settled_stream_changes_nothing(seed, views):
    rng = np.random.default_rng(seed)
    film = Film(SUPERPOINTS, max_rounds=20, views=8)
    for _ in range(views):
        film.show(imperfect_view(rng))
    before = film.groups()
    change = film.association.settle()
    assert film.groups() == before
    assert (change.founded, change.merged) == ((), ())
    assert change.changed.tolist() == []


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000), views=st.integers(1, 20))
def test_a_full_pass_changes_nothing_where_things_touch_either(seed, views):
    rng = np.random.default_rng(seed)
    film = Film(SUPERPOINTS, max_rounds=20, views=8)
    for _ in range(views):
        film.show(imperfect_view(rng), contacts=side_by_side(rng), colours=stuff(rng))
    before = film.groups()
    assert film.association.settle().changed.tolist() == []
    assert film.groups() == before


def side_by_side(rng):
    """Return contacts of a row of superpoints; between objects the surface mostly bends."""
    length = rng.integers(1, 9, SUPERPOINTS - 1)
    same = OBJECTS[1:] == OBJECTS[:-1]
    unbent = np.where(same, length, np.minimum(length, rng.integers(0, 2, len(length))))
    number = range(SUPERPOINTS)
    return touching(*zip(number[:-1], number[1:], length, unbent, strict=True))


def stuff(rng):
    """Return the colours of some superpoints; two of the three objects are much alike."""
    lightness = np.array([20, 26, 40])[OBJECTS] + rng.normal(0, 2, SUPERPOINTS)
    return coloured(
        **{f"s{s}": lightness[s] for s in np.flatnonzero(rng.random(SUPERPOINTS) < 0.7)}
    )


FOUND = {frozenset(range(4 * k, 4 * k + 4)) for k in range(3)}


def films_that_end_right(every):
    """Return how many of 40 films of 30 views, shown at a part of their rate, end right."""
    found = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        film = Film(SUPERPOINTS)
        for view in range(30):
            labels, around, colours = imperfect_view(rng), side_by_side(rng), stuff(rng)
            if view % every == 0:
                film.show(labels, contacts=around, colours=colours)
        film.show({})
        found += film.partition() == FOUND
    return found


def test_three_objects_are_found_through_imperfect_masks_at_every_rate():
    assert films_that_end_right(every=1) >= 38
    assert films_that_end_right(every=2) >= 33
    assert films_that_end_right(every=3) >= 33


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_the_table_of_covered_pixels_is_the_sum_of_the_evidence(seed):
    rng = np.random.default_rng(seed)
    film = Film(SUPERPOINTS, views=4)
    for _ in range(12):
        film.show(noise(rng))
        for change in replaced(rng) if film.keyframe % 3 == 0 else ():
            film.show({}, change)
    association = film.association
    everyone = np.arange(SUPERPOINTS, dtype=np.int32)
    entries = association._evidence.entries(everyone)
    summed = Coverage(top_views=1, min_pixels=1)
    summed.open_segments(association._coverage.segments - 1, keyframe=0)
    summed.add(association.of(everyone)[entries.row], entries.segment, entries.pixels)
    assert_equal_coverage(association._coverage, summed)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_groups_that_are_reported_are_groups_that_live(seed):
    rng = np.random.default_rng(seed)
    film = Film(SUPERPOINTS)
    alive: set[int] = set()
    for _ in range(20):
        before = alive
        change = film.show(noise(rng))
        alive = {group for group in film.groups() if group >= 0}
        founded = {group for group, _ in change.founded}
        assert alive - before <= founded
        assert before ^ alive <= set(change.changed.tolist())
        assert set(change.seen.tolist()) <= alive
        assert {emptied for emptied, _ in change.merged} <= before | founded


def assert_equal_coverage(one: Coverage, other: Coverage) -> None:
    assert one._by_region.key.tolist() == other._by_region.key.tolist()
    assert one._by_region.total.tolist() == other._by_region.total.tolist()
    assert one.owners().tolist() == other.owners().tolist()


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_segments_can_get_other_numbers_at_any_time(seed):
    rng = np.random.default_rng(seed)
    plain, renumbered = Film(SUPERPOINTS, views=4), Film(SUPERPOINTS, views=4)
    for _ in range(20):
        labels = imperfect_view(rng)
        one, other = plain.show(labels), renumbered.show(labels)
        assert (one.founded, one.merged) == (other.founded, other.merged)
        assert plain.groups() == renumbered.groups()
        renumbered.association.renumber()
    assert renumbered.association._coverage.segments < plain.association._coverage.segments
