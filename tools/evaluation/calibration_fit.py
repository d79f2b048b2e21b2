"""Temperature, "none of them" and thresholds for one encoder.

Fitted on recordings that nothing else is told of.
"""

from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass, replace
from typing import Any

import numpy as np

from sceneq_core.evaluation.familiarity_fit import fit_familiarity
from sceneq_core.evaluation.gate_tuning import tune_gate
from sceneq_core.evaluation.null_fit import fit_null
from sceneq_core.evaluation.proper_scores import log_loss
from sceneq_core.evaluation.sureness_fit import fit_sureness
from sceneq_core.evaluation.temperature import fit_temperature
from sceneq_core.routing.null import Evidence, NullParams
from sceneq_core.routing.sureness import Sureness
from sceneq_core.routing.unfamiliar import Unfamiliar, scene_familiarity
from sceneq_nodes._calibration import Calibration
from sceneq_tools.evaluation.absent_names import absent_names, absent_purposes
from sceneq_tools.evaluation.calibration import (
    CalibrationReport,
    Scene,
    evaluate_calibration,
    labels_of,
    questions_of,
)
from sceneq_tools.evaluation.calibration_guesses import decisions, question_guesses
from sceneq_tools.evaluation.retrieval_candidates import Candidates
from sceneq_tools.evaluation.retrieval_queries import Query
from sceneq_tools.evaluation.retrieval_setup import Setup

QUESTIONS, LABELS, BOTH = "questions", "labels", "both"
TASKS = (QUESTIONS, LABELS, BOTH)
DIGITS = 4
IN_VAIN = 1.0
"""What all purposes that nothing serves count together: as one question. How often people ask for
what nothing is good for the recordings tell; where none asks, this is the rule of succession."""


@dataclass(frozen=True, slots=True, eq=False)
class Counted:
    """A question about a scene, whether anything is ``present``, how much it counts."""

    candidates: Candidates
    query: Query
    present: bool
    described: bool
    count: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Examples:
    """Scenes of one kind: their ``true`` instances, and ``maps`` of them."""

    true: tuple[Scene, ...] = ()
    maps: tuple[Scene, ...] = ()

    @property
    def all(self) -> tuple[Scene, ...]:
        """Both."""
        return (*self.true, *self.maps)


NOTHING = Examples()


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A calibration, what it was fitted on, and the measures there before and after.

    ``strange``: the measures after it on what looks strange, ``None`` where nothing does.
    """

    calibration: Calibration
    task: str
    before: CalibrationReport
    after: CalibrationReport
    strange: CalibrationReport | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return the content of calibration.json."""
        return {
            **self.calibration.as_dict(),
            "recordings": list(self.after.recordings),
            "temperature_fitted_on": self.task,
            "label_set": self.after.tasks[1].choices,
            "before": brief(self.before),
            "after": brief(self.after),
            "strange": brief(self.strange) if self.strange else None,
        }


def fit(
    scenes: Sequence[Scene],
    setup: Setup,
    task: str,
    maps: Sequence[Scene] = (),
    strange: Examples = NOTHING,
) -> Fitted:
    """Fit T by the mean negative log-likelihood of ``task``, "none of them", sureness, then gate.

    "None of them" is fitted by the likelihood of whether there is a right one, sureness by that of
    whether the first guess is right, the gate by F1 on questions; ``before`` is without any
    calibration. ``maps`` are asked the same questions as the true instances in ``scenes``, but name
    nothing: what a fragment is called has no right answer. On ``strange`` scenes all but the gate
    is fitted once more, and how to tell them.

    Raises:
        ValueError: nothing in the scenes has a right answer to fit to.
    """
    plain, known = setup.with_calibration(None), Examples(tuple(scenes), tuple(maps))
    ungated = replace(
        _ungated(known, plain, task),
        label_set=plain.router.labeller.label_set.name,
        sha256=tuple(scene.questioned.sha256 for scene in scenes),
    )
    if strange.all:
        ungated = _knowing_strangers(ungated, known, strange, plain, task)
    asked = questions_of((*known.all, *strange.all), plain.with_calibration(ungated).router)
    tuned = tune_gate(decisions(asked), ungated.gate, setup.params.judge.min_claim)
    calibration = replace(ungated, gate=tuned)
    calibrated = plain.with_calibration(calibration)
    return Fitted(
        calibration=calibration,
        task=task,
        before=evaluate_calibration(scenes, plain),
        after=evaluate_calibration(scenes, calibrated),
        strange=evaluate_calibration(strange.true, calibrated) if strange.true else None,
    )


def _ungated(examples: Examples, plain: Setup, task: str) -> Calibration:
    """Return T, "none of them" and sureness for one kind of scenes."""
    temperature = fit_temperature(lambda t: _loss(examples.true, examples.maps, plain, task, t))
    warm = _untuned(plain, round(temperature, DIGITS))
    null, null_described = _nulls(examples.all, plain, warm)
    told = replace(warm, null=null, null_described=null_described)
    sureness = _sureness(examples.all, plain.with_calibration(told)) if null else None
    return replace(told, sureness_described=sureness)


def _knowing_strangers(
    known: Calibration, at_home: Examples, strange: Examples, plain: Setup, task: str
) -> Calibration:
    """Return a calibration that also knows how sure to be of what looks strange."""
    abroad = _ungated(strange, plain, task)
    looks = [
        np.array([scene_familiarity(one.candidates.snapshot.columns) for one in examples.all])
        for examples in (at_home, strange)
    ]
    middle, slope = (round(value, DIGITS) for value in fit_familiarity(*looks))
    unfamiliar = Unfamiliar(
        temperature=abroad.temperature,
        middle=middle,
        slope=slope,
        null=abroad.null,
        null_described=abroad.null_described,
        sureness_described=abroad.sureness_described,
    )
    return replace(known, unfamiliar=unfamiliar)


def brief(report: CalibrationReport) -> dict[str, Any]:
    """Return the few numbers that say how good a calibration is."""
    tasks = {
        f"{one.task.partition(':')[0]} ({one.choices})": {
            "guesses": one.guesses,
            "accuracy": round(one.accuracy, DIGITS),
            "nll": round(one.nll, DIGITS),
            "ece": round(one.ece_width, DIGITS),
        }
        for one in report.tasks
    }
    return {"temperature": report.temperature, **tasks, "routing_f1": report.routing.f1.f1}


def _untuned(setup: Setup, temperature: float) -> Calibration:
    """Return a calibration of the temperature alone."""
    return Calibration(setup.encoder.model_id, temperature, setup.params.judge.gate)


def _nulls(
    scenes: Sequence[Scene], setup: Setup, warm: Calibration
) -> tuple[NullParams | None, NullParams | None]:
    """Return how probable "none of them" is for words that name, and for words that describe.

    ``None`` for all without questions that tell; for words that describe, then they are as names.
    """
    counted = _counted(scenes, setup)
    present, absent = ([one for one in counted if one.present is is_so] for is_so in (True, False))
    if not present or not absent:
        return None, None
    described = [one for one in counted if one.described]
    if len({one.present for one in described}) < 2:
        return _null(counted, setup, warm), None
    named = [one for one in counted if not one.described]
    if len({one.present for one in named}) < 2:
        return _null(counted, setup, warm), None
    return _null(named, setup, warm), _null(described, setup, warm)


def _counted(scenes: Sequence[Scene], setup: Setup) -> list[Counted]:
    """Return all questions of the scenes and how much each counts.

    Half of what the absent names in the recordings count goes to other names that are asked for in
    vain, all alike: a few questions are soon learned by heart. Descriptions in vain count
    ``IN_VAIN`` together.
    """
    asked = [one for scene in scenes for one in _asked(scene, scene.questioned.queries, setup)]
    vain = [one for scene in scenes for one in _asked(scene, _in_vain(scene, setup), setup)]
    names, purposes = ([one for one in vain if one.described is is_so] for is_so in (False, True))
    absent = sum(not one.present and not one.described for one in asked)
    half = 0.5 if names else 1.0
    told = [one if one.present or one.described else replace(one, count=half) for one in asked]
    told += [replace(one, count=0.5 * absent / len(names)) for one in names]
    return told + [replace(one, count=IN_VAIN / len(purposes)) for one in purposes]


def _asked(scene: Scene, queries: Sequence[Query], setup: Setup) -> Iterator[Counted]:
    for query in queries:
        for one in question_guesses(setup.router, scene.candidates, [query]):
            yield Counted(scene.candidates, query, one.has_answer, one.described)


def _in_vain(scene: Scene, setup: Setup) -> tuple[Query, ...]:
    """Return questions for everything that is not there, and that nothing there is good for."""
    things = scene.questioned.things
    return (*absent_names(setup.router, things), *absent_purposes(things))


def _null(counted: Sequence[Counted], setup: Setup, warm: Calibration) -> NullParams:
    """Return how probable "none of them" is, fitted on these questions."""

    def evidence_at(temperature: float) -> list[Evidence]:
        tried = replace(warm, null=NullParams(temperature, 1.0, 1.0, 1.0, 0.0))
        router = setup.with_calibration(tried).router
        guesses = (
            question_guesses(router, one.candidates, [one.query], setup.router) for one in counted
        )
        return [one.evidence for asked in guesses for one in asked]

    present = np.array([one.present for one in counted], np.bool_)
    fitted = fit_null(evidence_at, present, np.array([one.count for one in counted]))
    return NullParams(*(round(value, DIGITS) for value in astuple(fitted)))


def _sureness(scenes: Sequence[Scene], setup: Setup) -> Sureness | None:
    """Return how sure first guesses for descriptions are, ``None`` where nothing is described."""
    asked = [one for one in questions_of(scenes, setup.router) if one.described]
    if not asked:
        return None
    seen = decisions([one.with_null for one in asked])
    fitted = fit_sureness(seen.p_max, seen.right)
    return Sureness(round(fitted.slope, DIGITS), round(fitted.shift, DIGITS))


def _loss(
    scenes: Sequence[Scene],
    maps: Sequence[Scene],
    setup: Setup,
    task: str,
    temperature: float,
) -> float:
    """Return the mean over the fitted tasks of their mean losses; NaN when there are none.

    Of the questions those count that have a right answer: T is about which one it is.
    """
    router = setup.with_calibration(_untuned(setup, temperature)).router
    asked = questions_of((*scenes, *maps), router, setup.router) if task != LABELS else []
    named = labels_of(scenes, router.labeller) if task != QUESTIONS else []
    parts = ([one for one in part if one.has_answer] for part in (asked, named))
    losses = [np.mean([log_loss(one.p, one.is_right) for one in part]) for part in parts if part]
    return float(np.mean(losses)) if losses else float("nan")
