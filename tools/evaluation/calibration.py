"""Do the probabilities mean what they say, and does the gate trust the right guesses?"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from sceneq_core.evaluation.gate_decisions import F1, Nudged, f1_of, sensitivity
from sceneq_core.evaluation.proper_scores import brier, log_loss, top_brier
from sceneq_core.evaluation.ranking import auroc
from sceneq_core.evaluation.reliability import (
    Bin,
    calibration_error,
    equal_mass_bins,
    equal_width_bins,
)
from sceneq_core.evaluation.risk_coverage import RiskCoverage, risk_coverage
from sceneq_core.evaluation.verified_error import (
    as_much_by_chance,
    debiased_error,
    error_interval,
    errors_without_fault,
)
from sceneq_core.routing.gate import GateParams
from sceneq_core.routing.labels import Labeller, LabelSet
from sceneq_core.routing.router import Router
from sceneq_tools.evaluation.calibration_claims import CLAIMS, Claims, claims_of, first_claim
from sceneq_tools.evaluation.calibration_guesses import (
    Guess,
    decisions,
    label_guesses,
    question_guesses,
)
from sceneq_tools.evaluation.retrieval_candidates import Candidates
from sceneq_tools.evaluation.retrieval_queries import Questioned
from sceneq_tools.evaluation.retrieval_setup import Setup

WIDTH_BINS, MASS_BINS = 15, 10

QUESTIONS = "questions: which instance is meant, or none of them; those without a relation"
NAMED = "named: those of the questions that name a thing"
DESCRIBED = "described: those that say what it is for, does or is made of"
SUPPOSING = "supposing: which instance is meant, of those where there is one and told so"
LABELS = "labels: what a true instance is called, of those whose name is in the label set"
PROTOCOL = (
    "NLL, Brier: all choices, several right ones count as one; ECE: p of the first guess, "
    f"{WIDTH_BINS} bins of equal width / {MASS_BINS} of equal mass, by chance: what probabilities "
    "without any fault would show on so few guesses, and how often as much; beyond: L2 error of "
    "the bins of equal mass without what chance adds (debiased, Kumar et al. 2019); 90 %: of the "
    "ECE by width, basic bootstrap; AURC: area under risk against "
    "coverage, least AURC: the least possible at this accuracy; AUROC: right against wrong "
    "first guesses"
)
ROUTING = (
    "routing F1: the gate should take the fast path exactly when the first guess is right; "
    "questions without a relation, those without a right instance included"
)
ROUTED = (
    "as routed: the whole router, with its demands on presence and its not_found, should answer "
    "at once exactly when that answer is right; all questions"
)


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """A recording's questions and its true instances as candidates."""

    questioned: Questioned
    candidates: Candidates


@dataclass(frozen=True, slots=True, eq=False)
class TaskScores:
    """How well the probabilities of one kind of guesses are calibrated.

    ``auroc`` is by what the gate looks at, ``None`` where all guesses are right or all wrong.
    ``ece_noise``: the ``ece_width`` that probabilities without any fault would show on average,
    ``ece_as_much``: how often as much; ``ece_beyond``: the debiased error; ``ece_interval``: where
    ``ece_width`` lies in nine of ten cases.
    """

    task: str
    choices: str
    guesses: int
    accuracy: float
    confidence: float
    nll: float
    brier: float
    top_brier: float
    ece_width: float
    ece_mass: float
    ece_noise: float
    ece_as_much: float
    ece_beyond: float
    ece_interval: tuple[float, float]
    bins: tuple[Bin, ...]
    mass_bins: tuple[Bin, ...]
    curve: RiskCoverage
    auroc: dict[str, float | None]

    def as_dict(self) -> dict[str, Any]:
        """Return everything in values that JSON knows."""
        plain = (
            *("task", "choices", "guesses", "accuracy", "confidence", "nll", "brier"),
            *("top_brier", "ece_width", "ece_mass", "ece_noise", "ece_as_much", "ece_beyond"),
            *("ece_interval", "auroc"),
        )
        return {
            **{name: getattr(self, name) for name in plain},
            "bins": [asdict(one) for one in self.bins],
            "mass_bins": [asdict(one) for one in self.mass_bins],
            "aurc": self.curve.area,
            "least_aurc": self.curve.least_area,
            "coverage": self.curve.coverage.tolist(),
            "risk": self.curve.risk.tolist(),
        }


@dataclass(frozen=True, slots=True, eq=False)
class RoutingScores:
    """How well the gate decides, and how that changes when a threshold does.

    ``as_routed`` is what becomes of it in the whole router, over all ``questions``, and ``claims``
    what it then claims.
    """

    gate: GateParams
    decisions: int
    right: int
    f1: F1
    sensitivity: tuple[Nudged, ...]
    questions: int
    as_routed: F1
    claims: Claims

    def as_dict(self) -> dict[str, Any]:
        """Return everything in values that JSON knows."""
        return {**asdict(self), "claims": self.claims.as_dict()}


@dataclass(frozen=True, slots=True, eq=False)
class CalibrationReport:
    """Calibration at ``temperature``, in all tasks, over all scenes together."""

    recordings: tuple[str, ...]
    temperature: float
    tasks: tuple[TaskScores, ...]
    routing: RoutingScores

    def as_dict(self) -> dict[str, Any]:
        """Return everything in values that JSON knows."""
        return {
            "protocol": PROTOCOL,
            "routing_protocol": ROUTING,
            "as_routed_protocol": ROUTED,
            "claims_protocol": CLAIMS,
            "recordings": list(self.recordings),
            "temperature": self.temperature,
            "tasks": [task.as_dict() for task in self.tasks],
            "routing": self.routing.as_dict(),
        }


def evaluate_calibration(scenes: Sequence[Scene], setup: Setup) -> CalibrationReport:
    """Measure the router of ``setup`` on true instances."""
    router = setup.router
    asked = questions_of(scenes, router)
    own = Labeller(own_labels(scenes), setup.tempered)
    return CalibrationReport(
        recordings=tuple(scene.questioned.name for scene in scenes),
        temperature=setup.tempered.temperature,
        tasks=(
            task_scores(QUESTIONS, "instances", [one.with_null for one in asked]),
            *(
                task_scores(LABELS, labeller.label_set.name, labels_of(scenes, labeller))
                for labeller in (router.labeller, own)
            ),
            task_scores(SUPPOSING, "instances", [o.supposing for o in asked if o.has_answer]),
            *(
                task_scores(
                    task, "instances", [o.with_null for o in asked if o.described is described]
                )
                for task, described in ((NAMED, False), (DESCRIBED, True))
            ),
        ),
        routing=routing_scores(scenes, router, asked),
    )


def questions_of(
    scenes: Sequence[Scene], router: Router, reader: Router | None = None
) -> list[Guess]:
    """Return the guesses of all questions of all scenes; ``reader`` as in ``question_guesses``."""
    return [
        guess
        for scene in scenes
        for guess in question_guesses(router, scene.candidates, scene.questioned.queries, reader)
    ]


def labels_of(scenes: Sequence[Scene], labeller: Labeller) -> list[Guess]:
    """Return the guesses of the names of all true instances of all scenes."""
    return [
        guess
        for scene in scenes
        for guess in label_guesses(labeller, scene.candidates, scene.questioned.things)
    ]


def own_labels(scenes: Sequence[Scene]) -> LabelSet:
    """Return the names of what can be answered with in the scenes: a closed label set."""
    seen = {
        thing.names[0].lower()
        for scene in scenes
        for thing in scene.questioned.things
        if scene.candidates.snapshot.find(thing.id) is not None
    }
    return LabelSet("own", tuple(sorted(seen)))


def task_scores(task: str, choices: str, guesses: Sequence[Guess]) -> TaskScores:
    """Return every measure of guesses that all have a right choice."""
    seen = decisions(guesses)
    bins = equal_width_bins(seen.p_max, seen.right, WIDTH_BINS)
    mass_bins = equal_mass_bins(seen.p_max, seen.right, MASS_BINS)
    return TaskScores(
        task=task,
        choices=choices,
        guesses=len(guesses),
        accuracy=_mean(seen.right.tolist()),
        confidence=_mean(seen.p_max.tolist()),
        nll=_mean([log_loss(guess.p, guess.is_right) for guess in guesses]),
        brier=_mean([brier(guess.p, guess.is_right) for guess in guesses]),
        top_brier=top_brier(seen.p_max, seen.right),
        ece_width=calibration_error(bins),
        ece_mass=calibration_error(mass_bins),
        ece_noise=_mean(errors_without_fault(seen.p_max, WIDTH_BINS).tolist()),
        ece_as_much=as_much_by_chance(seen.p_max, seen.right, WIDTH_BINS),
        ece_beyond=debiased_error(mass_bins),
        ece_interval=error_interval(seen.p_max, seen.right, WIDTH_BINS),
        bins=bins,
        mass_bins=mass_bins,
        curve=risk_coverage(seen.p_max, seen.right),
        auroc={
            "p_max": auroc(seen.p_max, seen.right),
            "margin": auroc(seen.margin, seen.right),
            "entropy": auroc(-seen.entropy_norm, seen.right),
        },
    )


def routing_scores(
    scenes: Sequence[Scene], router: Router, asked: Sequence[Guess]
) -> RoutingScores:
    """Return how well the gate and the whole router decide; the gate decides on ``asked``."""
    gate, seen = router.params.judge.gate, decisions(asked)
    made = [
        first_claim(router, scene.candidates, query)
        for scene in scenes
        for query in scene.questioned.queries
    ]
    at_once = np.array([one.enough for one in made], np.bool_)
    right = np.array([one.is_right for one in made], np.bool_)
    return RoutingScores(
        gate=gate,
        decisions=len(seen),
        right=int(seen.right.sum()),
        f1=f1_of(seen.accepted(gate), seen.right),
        sensitivity=sensitivity(seen, gate),
        questions=len(right),
        as_routed=f1_of(at_once, right),
        claims=claims_of(made, asked),
    )


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if len(values) else 0.0
