"""When a verdict still holds, and what ends it."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.reasoning.reasoner import LabelProblem, LabelVerdict, Problem, Usage, Verdict
from sceneq_core.routing.candidates import pose_problem
from sceneq_core.routing.remembered import Remembered, RememberedParams, still_holds

from support.furnished import ROOM, furnish, ids, router

PARAMS = RememberedParams()
VERDICT = Verdict(((6, 0.8),), "seen", 2, Usage(1600, 9, 0.01))
TEXT = "the cup on the coffee table"


def problem(text: str = TEXT, things=ROOM, scene=None, top_k: int = 5) -> Problem:
    brain, here = router(), (scene or furnish(things, noise=0.0)).snapshot()
    question = brain.read(text)
    posed = pose_problem(here, question, brain.fits(here, question), top_k)
    assert posed is not None
    return posed


def moved(name: str, by_m: float):
    """The room with one thing elsewhere."""
    shift = np.array([by_m, 0.0, 0.0])
    return tuple(
        thing._replace(low=tuple(thing.low + shift), high=tuple(thing.high + shift))
        if thing.name == name
        else thing
        for thing in ROOM
    )


def kept(then: Problem, verdict: Verdict = VERDICT) -> Remembered[Verdict]:
    remembered: Remembered[Verdict] = Remembered(PARAMS)
    remembered.keep(then, verdict)
    return remembered


def test_the_same_question_about_the_same_things_is_free():
    again = kept(problem()).recall(problem("The cup  on the COFFEE table"))
    assert again == replace(VERDICT, cached=True)
    assert (VERDICT.billed, again.billed) == ((2, VERDICT.usage), (0, Usage()))


def test_another_question_is_another_one():
    assert kept(problem()).recall(problem("the cup next to the coffee table")) is None
    assert kept(problem()).recall(problem("the red cup on the coffee table")) is None


def test_a_candidate_that_moves_ends_it():
    remembered = kept(problem())
    assert remembered.recall(problem(things=moved("red cup", 0.04)))
    assert remembered.recall(problem(things=moved("red cup", 0.06))) is None
    assert remembered.recall(problem()) is None  # forgotten for good


def test_an_anchor_that_moves_ends_it():
    assert kept(problem()).recall(problem(things=moved("coffee table", 0.06))) is None


def test_slow_drift_adds_up():
    remembered = kept(problem())
    for step in (0.02, 0.04):
        assert remembered.recall(problem(things=moved("red cup", step)))
    assert remembered.recall(problem(things=moved("red cup", 0.06))) is None


def test_what_moves_elsewhere_does_not_matter():
    first = problem(top_k=2)
    assert {c.instance_id for c in first.candidates}.isdisjoint(ids("lamp"))
    assert kept(first).recall(problem(things=moved("lamp", 1.0), top_k=2))


def test_a_new_rival_ends_it_and_a_new_stranger_does_not():
    scene = furnish(noise=0.0)
    first = problem(scene=scene, top_k=2)
    assert still_holds(first, _with("shower curtain", first), PARAMS)
    assert not still_holds(first, _with("cup", first), PARAMS)


def _with(name: str, like: Problem) -> Problem:
    """The problem after something of that name was found in the room."""
    thing = ROOM[5]._replace(name=name)
    return problem(like.text, (*ROOM, thing), top_k=2)


def test_a_candidate_that_is_gone_ends_it():
    first = problem(top_k=2)
    fewer = replace(first, candidates=first.candidates[1:])
    assert kept(first).recall(fewer) is None


@pytest.mark.parametrize(
    "change",
    [{"label": "bowl"}, {"supported_by": 3}, {"inside": 8}, {"box_size_m": np.full(3, 0.5)}],
)
def test_a_candidate_that_becomes_something_else_ends_it(change):
    first = problem()
    changed = (replace(first.candidates[0], **change), *first.candidates[1:])
    assert kept(first).recall(replace(first, candidates=changed)) is None


def test_only_p_beside_the_best_candidate_counts():
    first = problem()
    diluted = tuple(replace(c, p=c.p / 3) for c in first.candidates)
    assert kept(first).recall(replace(first, candidates=diluted))
    best = max(first.candidates, key=lambda c: c.p)
    rival = tuple(
        replace(c, p=best.p * 0.9) if c is not best and c.role == best.role else c
        for c in first.candidates
    )
    assert kept(first).recall(replace(first, candidates=rival)) is None


def test_a_box_that_is_turned_is_the_same_box():
    """Axes of a box may be swapped from one map to the next: its extent counts."""
    first = problem()
    one = first.candidates[0]
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    T_world_box = one.T_world_box.copy()
    T_world_box[:3, :3] = one.T_world_box[:3, :3] @ turn
    turned = replace(one, T_world_box=T_world_box, box_size_m=one.box_size_m[[1, 0, 2]])
    assert kept(first).recall(replace(first, candidates=(turned, *first.candidates[1:])))


def test_another_map_ends_it():
    first = problem()
    assert first.map_epoch == 5
    assert kept(first).recall(replace(first, map_epoch=6)) is None


def test_the_viewpoint_counts_where_the_question_needs_it():
    for text, counts in (
        (TEXT, False),
        ("the largest cup", False),
        ("the cup left of the couch", True),
        ("the leftmost cup", True),
        ("nearest cup", True),
    ):
        scene = furnish(noise=0.0)
        first = problem(text, scene=scene)
        scene.move_viewpoint(first.viewpoint_world + np.array([0.3, 0.0, 0.0]))
        assert (kept(first).recall(problem(text, scene=scene)) is None) == counts, text


def test_time_and_money_do_not_count():
    hurried = replace(problem(), time_s=0.5, may_spend=False)
    assert kept(problem()).recall(hurried)


def test_what_cost_nothing_holds_only_while_nothing_changes():
    free = Verdict(((6, 0.8),), "by geometry", 0)
    assert kept(problem(), free).recall(problem())
    assert kept(problem(), free).recall(problem(things=moved("red cup", 0.001))) is None


def test_the_oldest_is_forgotten_first():
    remembered: Remembered[Verdict] = Remembered(RememberedParams(capacity=2))
    asked = [problem(text) for text in ("cup on the table", "cup on the box", "cup in the box")]
    remembered.keep(asked[0], VERDICT)
    remembered.keep(asked[1], VERDICT)
    assert remembered.recall(asked[0])
    remembered.keep(asked[2], VERDICT)
    assert [remembered.recall(one) is not None for one in asked] == [True, False, True]


def test_without_capacity_nothing_is_remembered():
    remembered: Remembered[Verdict] = Remembered(RememberedParams(capacity=0))
    remembered.keep(problem(), VERDICT)
    assert remembered.recall(problem()) is None


def test_a_name_holds_while_the_same_views_show_the_same_labels():
    box = (1.0, 2.0, 3.0, 4.0)
    first = LabelProblem(7, (("cup", 0.5), ("bowl", 0.3)), ((10, box), (20, box)))
    remembered: Remembered[LabelVerdict] = Remembered(PARAMS)
    verdict = LabelVerdict((("cup", 1.0),), "seen", 3)
    remembered.keep(first, verdict)
    moved_box = replace(first, views=((10, (1.5, 2.0, 3.0, 4.0)), (20, box)))
    assert remembered.recall(moved_box) == replace(verdict, cached=True)
    assert remembered.recall(replace(first, instance_id=8)) is None
    for changed in (
        replace(first, views=((10, box), (30, box))),
        replace(first, labels=(("cup", 0.5), ("pot", 0.3))),
        replace(first, labels=(("cup", 0.35), ("bowl", 0.3))),
    ):
        remembered.keep(first, verdict)
        assert remembered.recall(changed) is None
    assert not still_holds(first, problem(), PARAMS)


@pytest.mark.parametrize("name", ["moved_m", "likely", "viewpoint_m", "tilt", "capacity"])
def test_bad_parameters_are_named(name):
    with pytest.raises(ValueError, match=name):
        RememberedParams(**{name: -1})
