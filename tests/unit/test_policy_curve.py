"""Policies replayed on outcomes that are known, and a model that is only pretended."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sceneq_core.evaluation.cost_accuracy import best_accuracy, mixed_accuracy
from sceneq_core.reasoning.reasoner import Candidate, LabelProblem, Problem, UnansweredError
from sceneq_core.routing.budget import Budget
from sceneq_core.routing.outlook import RELATION, THING
from sceneq_core.routing.policy import Case
from sceneq_tools.evaluation.ablation import evaluate_ablation
from sceneq_tools.evaluation.calibration import Scene
from sceneq_tools.evaluation.policies import curves_of, save, tell
from sceneq_tools.evaluation.policy_chart import chart
from sceneq_tools.evaluation.policy_curve import contenders, curve
from sceneq_tools.evaluation.policy_outcomes import SCALES, Outcome, outcomes_of, skills_of
from sceneq_tools.evaluation.policy_replay import Contender, replay
from sceneq_tools.evaluation.retrieval_candidates import Candidates
from sceneq_tools.evaluation.retrieval_queries import Query, Questioned
from sceneq_tools.evaluation.simulated_vlm import SimulatedVlm

from support.furnished import WordEncoder, ids, router, snapshot
from support.questioned import hash_setup

SCENE = snapshot()
HERE = Candidates(
    "true instances",
    SCENE,
    {"exact": {one.instance_id: frozenset([one.instance_id]) for one in SCENE.instances}},
)
QUERIES = (
    Query("lamp", "category", frozenset(ids("lamp"))),
    Query("the trash can next to the coffee table", "spatial", frozenset(ids("trash can"))),
    Query("box", "category", frozenset(ids("chair"))),  # a wrong answer key
    Query("grand piano", "absent", frozenset()),
)


def scene(name: str = "room") -> Scene:
    return Scene(Questioned(Path(name), (), QUERIES, "0" * 64), HERE)


def setup():
    return replace(hash_setup(), encoder=WordEncoder(), router=router())


def outcome(
    recording: str = "a",
    kind: str = THING,
    p_right: float = 0.5,
    fast: bool = False,
    reasoned: bool = True,
    passes: bool = False,
) -> Outcome:
    case = Case(kind, passes, p_right)
    gate = dict.fromkeys(SCALES, passes)
    return Outcome(recording, case, gate, fast, reasoned, fast != reasoned, 1)


def problem(targets: int = 4) -> Problem:
    one = Candidate(0, "target", "cup", "cup", 0.2, 0.1, np.zeros(3), np.eye(4), np.ones(3), ())
    candidates = tuple(replace(one, instance_id=i) for i in range(1, targets + 1))
    return Problem("cup", "cup", (), candidates, np.array([0.0, 0.0, 1.0]), np.zeros(3))


def share_right(accuracy: float, right: set[int], says: tuple) -> float:
    told = [
        SimulatedVlm(frozenset(right), accuracy, f"seed {n}").solve(problem()) for n in range(400)
    ]
    best = [one.ranking[0][0] if one.ranking else None for one in told]
    assert all(one.vlm_calls == 1 for one in told)
    return sum(one in says for one in best) / len(best)


@pytest.mark.parametrize("accuracy", [0.0, 0.8, 1.0])
def test_the_simulated_model_is_as_often_right_as_it_is_told(accuracy):
    assert share_right(accuracy, {2, 3}, (2, 3)) == pytest.approx(accuracy, abs=0.05)
    assert share_right(accuracy, set(), (None,)) == pytest.approx(accuracy, abs=0.05)
    assert share_right(accuracy, {99}, (None,)) == pytest.approx(accuracy, abs=0.05)


def test_the_simulated_model_says_the_same_again():
    model = SimulatedVlm(frozenset([2]), 0.5, "a question")
    first = model.solve(problem())
    assert first == model.solve(problem())
    assert sum(p for _, p in first.ranking) <= 1.0  # what is missing is "none of them"
    with pytest.raises(UnansweredError):
        model.label(LabelProblem(1, (("cup", 1.0),), ()))


def test_a_right_answer_without_wrong_ones_is_found_by_any_accuracy():
    everything = SimulatedVlm(frozenset(), 0.0, "x")
    assert everything.solve(problem(0)).ranking == ()


def test_random_choice_is_a_straight_line():
    assert mixed_accuracy(0.5, (0.0, 0.6), (1.0, 0.8)) == pytest.approx(0.7)
    assert mixed_accuracy(2.0, (0.0, 0.6), (1.0, 0.8)) == pytest.approx(0.8)
    assert mixed_accuracy(0.0, (0.0, 0.6), (0.0, 0.6)) == 0.6


def test_foresight_takes_what_is_mended_first():
    gains = [1, 1, -1, 0]
    assert best_accuracy(0.25, gains, 0.5) == 0.75
    assert best_accuracy(1.0, gains, 0.5) == 1.0
    assert best_accuracy(1.0, [], 0.0) == 0.0


def test_outcomes_are_those_of_the_front_door():
    found = outcomes_of([scene()], setup(), None, 0)
    lamp, relation, wrong_key, absent = found
    assert [one.case.kind for one in found[:2]] == [THING, RELATION]
    assert lamp.fast_right
    assert lamp.passes[1.0]
    assert relation.reasoned_right
    assert not relation.passes[1.0]
    assert not wrong_key.fast_right
    assert absent.fast_right
    assert [one.calls for one in found] == [1, 1, 1, 1]  # geometry counts as a call
    assert {one.passes[0.25] >= one.passes[1.5] for one in found} == {True}


def test_the_ends_and_the_paper_are_those_of_the_plain_ablation():
    results = evaluate_ablation([scene()], setup()).results
    plain = [result.bucket("all").hit_1 / 4 for result in results]
    one = curve("x", outcomes_of([scene()], setup(), None, 0), 1, 0)
    points = [one.point("never"), one.point("thresholds", "x 1"), one.point("always")]
    assert [point.accuracy for point in points] == plain
    assert points[1].cost == results[1].bucket("all").reasoned / 4


def test_a_simulated_model_replaces_the_reasoner():
    perfect = outcomes_of([scene()], setup(), 1.0, 0)
    assert [one.reasoned_right for one in perfect] == [True] * 4


def test_skills_are_counted_by_kind():
    outcomes = [
        outcome(fast=False, reasoned=True),
        outcome(fast=False, reasoned=False),
        outcome(fast=True, reasoned=True),
        outcome(kind=RELATION, fast=True, reasoned=False),
    ]
    skills = skills_of(outcomes)
    assert (skills[THING].mends, skills[THING].keeps) == (0.5, 1.0)
    assert skills[RELATION].keeps == 0.0
    assert skills[RELATION].mends == 0.5  # nothing told: the usual opinion


def test_a_fixed_policy_by_hand():
    outcomes = [outcome(passes=n % 2 == 0, fast=n % 4 == 0) for n in range(8)]
    never = replay(outcomes, Contender("never", ""), 2, 0)
    always = replay(outcomes, Contender("always", ""), 2, 0)
    gate = replay(outcomes, Contender("thresholds", ""), 2, 0)
    assert (never.cost, never.accuracy) == (0.0, 0.25)
    assert (always.cost, always.accuracy) == (1.0, 1.0)
    assert (gate.cost, gate.accuracy, gate.refused) == (0.5, 0.75, 0.0)


def test_a_budget_refuses_and_says_how_often():
    outcomes = [outcome() for _ in range(60)]
    result = replay(outcomes, Contender("always", "", Budget(calls_per_hour=15)), 1, 0)
    assert (result.cost, result.refused) == (0.25, 0.75)
    assert result.accuracy == 0.25


def test_adaptive_learns_from_the_other_recordings_where_to_spend():
    """Relations are always mended and things never: half the calls bring all there is to gain."""
    outcomes = [
        outcome(recording, kind, 0.5, fast=n % 2 == 0, reasoned=kind == RELATION or n % 2 == 0)
        for recording in ("a", "b")
        for kind in (THING, RELATION)
        for n in range(40)
    ]
    result = replay(outcomes, Contender("adaptive", ""), 2, 0)
    assert (result.cost, result.accuracy) == (0.5, 0.75)
    poor = Contender("adaptive", "", Budget(calls_per_hour=12))
    limited = replay(outcomes, poor, 2, 0)
    fixed = replay(outcomes, replace(poor, policy="thresholds"), 2, 0)
    assert limited.cost <= 0.3
    assert limited.accuracy - 0.5 >= 1.3 * (fixed.accuracy - 0.5)


def test_a_curve_is_told_written_and_drawn(tmp_path, capsys):
    curves = curves_of([scene("a"), scene("b")], setup(), [0.9])
    assert [one.reasoner for one in curves] == ["GeometricReasoner", "simulated model, right 90 %"]
    assert [len(one.points) for one in curves] == [len(contenders())] * 2
    tell(curves)
    told = capsys.readouterr().out
    assert "adaptive" in told
    assert "policy: {kind: adaptive, outlook: {thing: {mends: " in told
    files = tmp_path / "curve.json", tmp_path / "curve.png"
    save(curves, [scene("a"), scene("b")], setup(), *files)
    document = json.loads(files[0].read_text())
    assert document["recordings"] == ["a", "b"]
    never = document["curves"][0]["points"][0]
    assert (never["policy"], never["cost"], never["beside_random"]) == ("never", 0.0, 0.0)
    assert files[1].read_bytes().startswith(b"\x89PNG")


def test_the_chart_has_a_panel_a_curve():
    one = curve("x", [outcome(fast=n % 2 == 0) for n in range(10)], 1, 0)
    single, double = chart([one]), chart([one, one])
    assert single.shape[0] == double.shape[0]
    assert double.shape[1] > 1.8 * single.shape[1] - 100
    assert len(np.unique(single.reshape(-1, 3), axis=0)) > 50
