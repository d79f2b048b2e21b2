"""Guesses, their measures and the fit, in a room whose encoder's noise is known."""

import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from sceneq_core.routing.gate import GateParams
from sceneq_core.routing.labels import Labeller, custom
from sceneq_tools.evaluation import calibration_fit
from sceneq_tools.evaluation.absent_names import absent_names
from sceneq_tools.evaluation.calibration import (
    Scene,
    evaluate_calibration,
    own_labels,
    task_scores,
)
from sceneq_tools.evaluation.calibration_claims import claims_of, first_claim
from sceneq_tools.evaluation.calibration_fit import BOTH, LABELS, QUESTIONS, fit
from sceneq_tools.evaluation.calibration_guesses import (
    Guess,
    decisions,
    label_guesses,
    question_guesses,
)
from sceneq_tools.evaluation.retrieval_candidates import Candidates
from sceneq_tools.evaluation.retrieval_queries import Query, Questioned
from sceneq_tools.evaluation.true_things import TrueThing

from support.furnished import ROOM, WordEncoder, ids, router, snapshot
from support.questioned import hash_setup

SHARP = snapshot(noise=0.6)
HERE = Candidates(
    "true instances",
    SHARP,
    {"exact": {one.instance_id: frozenset([one.instance_id]) for one in SHARP.instances}},
)
THINGS = tuple(
    TrueThing(number, f"thing {number}", (thing.name.split()[-1], thing.name), False, 0)
    for number, thing in enumerate(ROOM, 1)
)
NAMES = sorted({thing.name for thing in ROOM})
QUERIES = (
    *(Query(name, "category", frozenset(ids(name))) for name in NAMES),
    Query("the box next to the chair", "spatial", frozenset(ids("box"))),
    Query("aquarium", "absent", frozenset()),
)
SCENES = [Scene(Questioned(Path("room"), THINGS, QUERIES, "f" * 64), HERE)]


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


@pytest.fixture(autouse=True)
def _few_absent_names(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(calibration_fit, "absent_names", partial(absent_names, many=6))


def setup():
    return replace(hash_setup(), encoder=WordEncoder(), router=router())


def guess(p: list[float], *right: int) -> Guess:
    return Guess("?", np.array(p), np.isin(np.arange(len(p)), right))


def test_measures_by_hand():
    scores = task_scores("a task", "things", [guess([0.8, 0.2], 0), guess([0.6, 0.4], 1)])
    assert (scores.guesses, scores.accuracy, scores.confidence) == (2, 0.5, pytest.approx(0.7))
    assert scores.nll == pytest.approx(-(np.log(0.8) + np.log(0.4)) / 2)
    assert scores.brier == pytest.approx((2 * 0.2**2 + 2 * 0.6**2) / 2)
    assert scores.top_brier == pytest.approx((0.2**2 + 0.6**2) / 2)
    assert scores.ece_width == scores.ece_mass == pytest.approx((0.2 + 0.6) / 2)
    assert scores.curve.risk.tolist() == [0.0, 0.5]
    assert scores.auroc == {"p_max": 1.0, "margin": 1.0, "entropy": 1.0}
    json.dumps(scores.as_dict())


def test_measures_of_nothing_are_zero():
    scores = task_scores("a task", "things", [])
    assert (scores.guesses, scores.nll, scores.ece_width) == (0, 0.0, 0.0)
    assert scores.auroc["p_max"] is None


def test_questions_with_a_relation_are_no_first_guesses():
    asked = question_guesses(router(), HERE, QUERIES)
    assert [one.what for one in asked] == [*NAMES, "aquarium"]
    assert all(one.p.sum() == pytest.approx(1) for one in asked)
    assert not asked[-1].has_answer
    chairs = next(one for one in asked if one.what == "chair")
    assert chairs.is_right.sum() == 3


def test_things_whose_names_are_no_label_are_left_out():
    encoder = WordEncoder()
    named = label_guesses(Labeller(custom(("Lamp", "box", "chair")), encoder), HERE, THINGS)
    assert sorted(one.what for one in named) == ["box", "chair", "chair", "chair", "lamp"]
    assert all(one.is_right.sum() == 1 for one in named)


def test_own_labels_are_the_names_of_the_candidates():
    extra = TrueThing(99, "unseen", ("ghost",), False, 0)
    scene = replace(SCENES[0], questioned=replace(SCENES[0].questioned, things=(*THINGS, extra)))
    labels = own_labels([scene]).labels
    assert "ghost" not in labels
    assert "cup" in labels
    assert len(labels) == len(set(labels))


def test_the_gate_sees_what_the_answer_reports():
    ask = router()
    seen = decisions(question_guesses(ask, HERE, QUERIES))
    answer = ask.answer(SHARP, ask.read(NAMES[0])).answer
    assert seen.p_max[0] == pytest.approx(answer.confidence.p_max)
    assert seen.entropy_norm[0] == pytest.approx(answer.confidence.entropy_norm)


def test_an_answer_at_once_is_right_when_it_finds_or_rightly_does_not():
    ask = router()
    lamp, absent = Query("lamp", "category", frozenset(ids("lamp"))), QUERIES[-1]
    found, missed = first_claim(ask, HERE, lamp), first_claim(ask, HERE, absent)
    assert (found.status, found.enough, found.is_right) == ("found", True, True)
    assert (missed.status, missed.enough, missed.is_right) == ("not_found", True, True)
    wrong = first_claim(ask, HERE, Query("lamp", "category", frozenset(ids("couch"))))
    assert (wrong.enough, wrong.is_right) == (True, False)
    asked = question_guesses(ask, HERE, QUERIES)
    claims = claims_of([found, missed, wrong], asked)
    assert (claims.found, claims.found_right, claims.risk) == (2, 1, 0.5)
    assert (claims.not_found, claims.not_found_right, claims.absent) == (1, 1, 1)
    assert claims.absence_auroc == 1.0
    assert first_claim(ask, HERE, QUERIES[-2]).enough is False  # relations are never


@pytest.mark.parametrize("task", [QUESTIONS, LABELS, BOTH])
def test_fitting_makes_what_it_fits_better(task):
    fitted = fit(SCENES, setup(), task)
    before = {one.task + one.choices: one.nll for one in fitted.before.tasks}
    after = {one.task + one.choices: one.nll for one in fitted.after.tasks}
    names = list(before)
    chosen = {QUESTIONS: names[3:], LABELS: names[1:2], BOTH: [names[1], names[3]]}[task]
    assert sum(after[name] for name in chosen) <= sum(before[name] for name in chosen) + 1e-6
    assert fitted.after.routing.f1.f1 >= fitted.before.routing.f1.f1
    assert fitted.after.temperature == fitted.calibration.temperature
    assert fitted.calibration.sha256 == ("f" * 64,)
    assert fitted.calibration.sureness_described is None  # nothing is described
    json.dumps(fitted.as_dict())


def test_descriptions_in_vain_count_as_one_question_together():
    things = tuple(replace(thing, affordances=("sit",)) for thing in THINGS)
    asked = (*QUERIES, Query("something to sit on", "affordance", frozenset(ids("chair"))))
    scenes = [Scene(Questioned(Path("room"), things, asked, "f" * 64), HERE)]
    counted = calibration_fit._counted(scenes, setup())
    vain = [one.count for one in counted if one.described and not one.present]
    assert len(vain) > 10
    assert sum(vain) == pytest.approx(1.0)
    named = [one for one in counted if not one.described]
    assert sum(one.count for one in named if not one.present) == pytest.approx(1.0)  # aquarium
    fitted = fit(scenes, setup(), QUESTIONS).calibration
    assert fitted.null_described is not None
    assert fitted.sureness_described is not None


def test_the_temperature_is_the_least_of_a_scan():
    best = fit(SCENES, setup(), QUESTIONS)
    nll = best.after.tasks[3].nll
    for factor in (0.7, 0.9, 1.1, 1.4):
        other = replace(best.calibration, temperature=best.calibration.temperature * factor)
        assert evaluate_calibration(SCENES, setup().with_calibration(other)).tasks[3].nll >= nll


def test_maps_without_a_right_instance_make_it_less_sure():
    lost = [replace(SCENES[0], candidates=replace(HERE, matches={"IoU >= 0.25": {}}))]
    alone, both = (fit(SCENES, setup(), QUESTIONS, some) for some in ([], lost))
    assert both.calibration.sha256 == alone.calibration.sha256  # the questions are the same
    assert both.after.recordings == ("room",)  # measured on true instances only
    sure, unsure = (guess_of("lamp", one.calibration).p_null for one in (alone, both))
    assert sure < 0.1 < 0.3 < unsure


def guess_of(text, calibration):
    asked = setup().with_calibration(calibration).router
    return question_guesses(asked, HERE, [Query(text, "absent", frozenset())])[0]


def test_nothing_to_fit_to_is_said():
    nobody = Questioned(Path("room"), (), (Query("aquarium", "absent", frozenset()),), "0" * 64)
    with pytest.raises(ValueError, match="loss"):
        fit([Scene(nobody, HERE)], setup(), QUESTIONS)


def test_the_report_is_plain_values_and_names_its_protocols():
    report = evaluate_calibration(SCENES, setup())
    document = json.loads(json.dumps(report.as_dict()))
    assert "ECE" in document["protocol"]
    assert document["routing"]["gate"]["min_p"] == GateParams().min_p
    assert [task["choices"] for task in document["tasks"]] == [
        *("instances", "scannet200", "own", "instances", "instances", "instances"),
    ]
    assert len(document["routing"]["sensitivity"]) == 12
