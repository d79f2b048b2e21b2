"""Every question is checked by plain geometry that shares nothing with the code that asked it."""

import re
from functools import cache
from itertools import product

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_tools.room.room import Thing
from sceneq_tools.room.truth.attributes import attributes
from sceneq_tools.room.truth.questions import BUCKETS, Question, Survey, questions

from support.random_room import random_room

SEEDS = st.integers(0, 11)
EVERYBODY = st.sampled_from([1, 2])
SAMPLES = np.array(list(product(np.linspace(0, 1, 9), repeat=3)))


@cache
def survey(seed: int, every: int) -> Survey:
    """A room of which every so many-th thing was seen well."""
    room = random_room(seed)
    solid = [thing for thing in room.things if not thing.is_stuff]
    well = frozenset(t.id for t in solid if t.id % every == 0 or t.id < 10)
    return Survey(room, well, {t.id: attributes(t) for t in solid})


@cache
def asked(seed: int, every: int) -> tuple[Question, ...]:
    return questions(survey(seed, every), np.random.default_rng(seed), per_bucket=50)


def of(seed: int, every: int, bucket: str, *kinds: str) -> list[Question]:
    found = [q for q in asked(seed, every) if q.bucket == bucket]
    return [q for q in found if q.kind in kinds] if kinds else found


def box(thing: Thing) -> np.ndarray:
    """The things of these rooms stand straight: their box is that of their corners."""
    corners = thing.mesh.vertices + thing.T_world_thing[:3, 3]
    return np.stack([corners.min(0), corners.max(0)])


def sampled_gap(a: Thing, b: Thing) -> float:
    """The distance between two boxes by brute force over a grid of points in one of them."""
    low, high = box(a)
    other = box(b)
    points = low + SAMPLES * (high - low)
    nearest = np.clip(points, other[0], other[1])
    return float(np.linalg.norm(points - nearest, axis=1).min())


def things(seed: int, every: int) -> dict[int, Thing]:
    return {thing.id: thing for thing in survey(seed, every).things}


def cups(label: str) -> set[str]:
    """What people do not tell apart in these rooms."""
    both = {"coffee mug", "plastic cup"}
    return both if label in both else {label}


def label_of(question: Question) -> str:
    match = re.fullmatch(r"the (.*?) (on|under|above|next to|closest to) the .*", question.text)
    assert match, question.text
    return match[1]


def overlaps(a: np.ndarray, b: np.ndarray) -> bool:
    return bool((a[0, :2] < b[1, :2]).all() and (b[0, :2] < a[1, :2]).all())


HOLDS = {
    "on": lambda a, b: abs(box(a)[0][2] - box(b)[1][2]) < 0.02 and overlaps(box(a), box(b)),
    "next_to": lambda a, b: 0 < sampled_gap(a, b) <= 0.25,
    "under": lambda a, b: box(a)[1][2] < box(b)[1][2] and overlaps(box(a), box(b)),
}


@given(SEEDS, EVERYBODY)
@settings(max_examples=24, deadline=None)
def test_nothing_hidden_is_asked_for_alone(seed: int, every: int) -> None:
    well = survey(seed, every).well
    for question in asked(seed, every):
        if question.bucket in ("attribute", "spatial") and question.kind != "material":
            assert set(question.targets) <= well
        if question.bucket != "absent":
            assert set(question.targets) & well


@given(SEEDS, EVERYBODY)
@settings(max_examples=24, deadline=None)
def test_texts_are_unique_and_the_buckets_are_known(seed: int, every: int) -> None:
    texts = [question.text for question in asked(seed, every)]
    assert len(texts) == len(set(texts))
    assert {question.bucket for question in asked(seed, every)} <= set(BUCKETS)


@given(SEEDS, EVERYBODY)
@settings(max_examples=24, deadline=None)
def test_a_name_means_all_of_one_kind_and_nothing_else(seed: int, every: int) -> None:
    present = things(seed, every)
    for question in of(seed, every, "category"):
        (label,) = {present[i].label for i in question.targets}
        named = {t.id for t in present.values() if question.text in (t.label, *t.category.synonyms)}
        assert named == set(question.targets)
        assert {t.id for t in present.values() if t.label in cups(label)} == named


@given(SEEDS, EVERYBODY)
@settings(max_examples=24, deadline=None)
def test_a_colour_singles_one_thing_out(seed: int, every: int) -> None:
    present = things(seed, every)
    for question in of(seed, every, "attribute", "colour"):
        _, colour, label = question.text.split(" ", 2)
        painted = {
            t.id
            for t in present.values()
            if t.label in cups(label) and (t.tint or "grey") == colour
        }
        assert painted == set(question.targets)


@given(SEEDS, EVERYBODY)
@settings(max_examples=24, deadline=None)
def test_the_tallest_is_the_tallest_by_far(seed: int, every: int) -> None:
    present = things(seed, every)
    for question in of(seed, every, "attribute", "size"):
        _, word, label = question.text.split(" ", 2)
        heights = {t.id: float(np.ptp(t.mesh.vertices, axis=0)[2]) for t in present.values()}
        volume = {t.id: float(np.ptp(t.mesh.vertices, axis=0).prod()) for t in present.values()}
        measure = heights if word == "tallest" else volume
        same = [i for i, t in present.items() if t.label in cups(label)]
        best = min(same, key=measure.get) if word == "smallest" else max(same, key=measure.get)
        assert question.targets == (best,)


@given(SEEDS, EVERYBODY)
@settings(max_examples=24, deadline=None)
def test_exactly_one_stands_there(seed: int, every: int) -> None:
    present = things(seed, every)
    for question in of(seed, every, "spatial", "on", "next_to", "under"):
        anchor = present[question.anchor]
        group = [t for t in present.values() if t.label in cups(label_of(question))]
        holds = HOLDS[question.kind]
        assert {t.id for t in group if holds(t, anchor)} == set(question.targets), question.text


@given(SEEDS, EVERYBODY)
@settings(max_examples=24, deadline=None)
def test_the_closest_is_the_closest_by_a_margin(seed: int, every: int) -> None:
    present = things(seed, every)
    for question in of(seed, every, "spatial", "nearest"):
        anchor = present[question.anchor]
        group = [t for t in present.values() if t.label in cups(label_of(question))]
        ranked = sorted(group, key=lambda t: sampled_gap(t, anchor))
        assert question.targets == (ranked[0].id,)
        assert sampled_gap(ranked[1], anchor) >= sampled_gap(ranked[0], anchor) + 0.3


@given(SEEDS, EVERYBODY)
@settings(max_examples=24, deadline=None)
def test_everything_that_serves_a_purpose_is_right(seed: int, every: int) -> None:
    served = {"something to drink from": "drink from", "something to read": "read"}
    present = things(seed, every)
    for question in of(seed, every, "affordance"):
        if verb := served.get(question.text):
            right = {t.id for t in present.values() if verb in t.category.affordances}
            assert right == set(question.targets)


@given(SEEDS, EVERYBODY)
@settings(max_examples=24, deadline=None)
def test_what_is_absent_is_absent(seed: int, every: int) -> None:
    present = things(seed, every)
    for question in of(seed, every, "absent"):
        assert question.targets == ()
        words = question.text.split(" ", 1)
        if question.kind == "colour":
            same = [t for t in present.values() if t.label in cups(words[1])]
            assert same
            assert all(t.tint != words[0] for t in same)
        else:
            assert all(question.text not in t.label for t in present.values())


def test_these_rooms_lead_to_questions_of_every_kind() -> None:
    kinds = {(q.bucket, q.kind) for seed in range(12) for q in asked(seed, 1)}
    assert {
        ("category", "name"), ("attribute", "colour"), ("attribute", "size"),
        ("attribute", "material"), ("spatial", "on"), ("spatial", "next_to"),
        ("spatial", "nearest"), ("affordance", "purpose"), ("absent", "name"),
        ("absent", "colour"),
    } <= kinds  # fmt: skip


def test_the_same_chance_asks_the_same() -> None:
    one, other = (questions(survey(3, 1), np.random.default_rng(3)) for _ in range(2))
    assert one == other


def test_a_name_whose_owner_has_gone_is_not_asked_for() -> None:
    from dataclasses import replace

    now = survey(3, 1)
    cup = next(t for t in now.things if t.label in cups("coffee mug"))
    before = replace(now, gone=(cup,))
    texts = [q.text for q in questions(before, np.random.default_rng(0), per_bucket=50)]
    assert not [text for text in texts if "mug" in text or "cup" in text or "drink" in text]
