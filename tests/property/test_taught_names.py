"""What holds of taught names whatever is taught."""

import string
from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_core.routing.labels import INHERITED, TAUGHT
from sceneq_core.teaching.evidence import Judgement, box_overlap
from sceneq_core.teaching.logistic import Logistic
from sceneq_core.teaching.wording import KINDS, clean_name, thing_of

from support.furnished import ROOM, router
from support.taught import TaughtRoom

ROUTER = router()
QUESTIONS = (
    "red cup",
    "the mug",
    "aunt Mary's mug",
    "chair next to the box",
    "what is on the box?",
)
NAMES = ("aunt Mary's mug", "my mug", "mug", "windsor", "Bertha", "box", "red cup")
IDS = st.integers(1, len(ROOM))
LESSONS = st.lists(st.tuples(IDS, st.sampled_from(NAMES), st.sampled_from(KINDS)), max_size=6)


def answers(room: TaughtRoom) -> list[object]:
    seen = room.seen
    told = []
    for text in QUESTIONS:
        one = ROUTER.answer(seen, ROUTER.read(text)).answer
        ranking = [(m.instance.instance_id, m.instance.label, m.p, m.cosine) for m in one.matches]
        told.append((ranking, one.status, one.reason, one.confidence, one.presence))
    names = [ROUTER.namer.label(seen, row) for row in range(len(seen))]
    return [told, [(one.labels, one.status, one.reason) for one in names]]


ROOM_BEFORE = TaughtRoom()
BEFORE = answers(ROOM_BEFORE)


@settings(max_examples=25, deadline=None)
@given(lessons=LESSONS)
def test_teaching_and_forgetting_changes_no_answer_at_all(lessons) -> None:
    room = TaughtRoom()
    for instance_id, name, kind in lessons:
        room.teach(instance_id, name, kind)
    room.seen  # noqa: B018 - the cosines that are remembered must not matter either
    room.book.forget(room.book.taught)
    assert answers(room) == BEFORE


@settings(max_examples=25, deadline=None)
@given(lessons=LESSONS)
def test_p_stays_a_distribution_and_every_label_a_probability(lessons) -> None:
    room = TaughtRoom()
    for instance_id, name, kind in lessons:
        room.teach(instance_id, name, kind)
    seen = room.seen
    for text in QUESTIONS:
        for fit in ROUTER.fits(seen, ROUTER.read(text)).values():
            assert abs(fit.p.sum() - 1.0) < 1e-9
            assert (np.diff(fit.p[fit.order]) <= 1e-15).all()
            assert 0.0 <= fit.presence <= 1.0
    for one in seen.instances:
        assert 0.0 <= one.label.p <= 1.0


@settings(max_examples=25, deadline=None)
@given(lessons=LESSONS, data=st.data())
def test_the_order_of_lessons_about_different_things_does_not_matter(lessons, data) -> None:
    distinct = list({name: (i, name, kind) for i, name, kind in lessons}.values())
    distinct = list({i: (i, name, kind) for i, name, kind in distinct}.values())
    shuffled = data.draw(st.permutations(distinct))
    labels = []
    for order in (distinct, shuffled):
        room = TaughtRoom()
        for instance_id, name, kind in order:
            room.teach(instance_id, name, kind)
        labels.append([(o.label.source, o.label.p) for o in room.seen.instances])
    taught = [[source == TAUGHT for source, _ in some] for some in labels]
    assert taught[0] == taught[1]


@given(
    cosines=st.lists(st.floats(-1, 1), min_size=2, max_size=8),
    weight=st.floats(0.1, 60),
    bias=st.floats(-60, 10),
)
def test_what_is_more_alike_inherits_with_no_less_p(cosines, weight, bias) -> None:
    p = Judgement(alike=Logistic((weight,), bias)).of_category(np.sort(cosines))
    assert (np.diff(p) >= 0).all()
    assert ((p >= 0) & (p <= 1)).all()


@settings(max_examples=20, deadline=None)
@given(noise=st.floats(0.0, 1.5), seed=st.integers(0, 9))
def test_in_a_room_what_is_more_alike_inherits_first(noise, seed) -> None:
    room = TaughtRoom(noise=noise)
    room.teach(11, "windsor", "category")
    heirs = [one.label for one in room.seen.instances if one.label.source == INHERITED]
    by_cosine = sorted(heirs, key=lambda label: label.cosine)
    assert [label.p for label in by_cosine] == sorted(label.p for label in heirs)
    others = [one for one in room.seen.instances if one.label.source not in (INHERITED, TAUGHT)]
    taught = room.book.taught[0]
    rest = room.album.cosines(taught, np.array([one.instance_id for one in others]))
    assert all(label.cosine >= rest.max() for label in heirs)


CORNER = st.tuples(*[st.floats(-5, 5)] * 3)
BOX = st.tuples(CORNER, CORNER).map(lambda pair: np.sort(np.array(pair), axis=0))


@given(one=BOX, other=BOX)
def test_overlap_is_symmetric_and_one_with_itself(one, other) -> None:
    shared = box_overlap(one, other[None])[0]
    assert shared == box_overlap(other, one[None])[0]
    assert 0.0 <= shared <= 1.0 + 1e-12
    assert abs(box_overlap(one, one[None])[0] - 1.0) < 1e-9


@given(text=st.text(alphabet=string.printable + "é’ßü", max_size=80))
def test_a_clean_name_is_spoken_by_the_question_for_it(text) -> None:
    try:
        name = clean_name(text)
    except ValueError:
        return
    assert clean_name(name) == name
    room = replace_names(name)
    assert room.names.meant(ROUTER.read(f"where is {name}").phrase.target, f"where is {name}")


def replace_names(name: str):
    """A snapshot in which one thing has the name."""
    room = TaughtRoom.__new__(TaughtRoom)
    room.__dict__.update(ROOM_BEFORE.__dict__)
    room.book = type(ROOM_BEFORE.book)(ROOM_BEFORE.book.params)
    room.teach(6, name)
    assert thing_of(name)
    return replace(room.seen)
