"""Temperature, "none of them" and thresholds for one encoder.

Fitted on recordings that nothing else is told of.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.evaluation.gate_tuning import tune_gate
from sceneq_core.evaluation.null_fit import fit_null
from sceneq_core.evaluation.proper_scores import log_loss
from sceneq_core.evaluation.temperature import fit_temperature
from sceneq_core.routing.null import NullParams
from sceneq_nodes._calibration import Calibration
from sceneq_tools.evaluation.calibration import (
    CalibrationReport,
    Scene,
    evaluate_calibration,
    labels_of,
    questions_of,
)
from sceneq_tools.evaluation.calibration_guesses import Guess, decisions
from sceneq_tools.evaluation.retrieval_setup import Setup

QUESTIONS, LABELS, BOTH = "questions", "labels", "both"
TASKS = (QUESTIONS, LABELS, BOTH)
DIGITS = 4


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A calibration, what it was fitted on, and the measures there before and after."""

    calibration: Calibration
    task: str
    before: CalibrationReport
    after: CalibrationReport

    def as_dict(self) -> dict[str, Any]:
        """Return the content of calibration.json."""
        return {
            **self.calibration.as_dict(),
            "recordings": list(self.after.recordings),
            "temperature_fitted_on": self.task,
            "label_set": self.after.tasks[1].choices,
            "before": brief(self.before),
            "after": brief(self.after),
        }


def fit(scenes: Sequence[Scene], setup: Setup, task: str) -> Fitted:
    """Fit T and "none of them" by the mean negative log-likelihood of ``task``, then the gate.

    The gate is tuned for the best F1 on questions. ``before`` is without any calibration.

    Raises:
        ValueError: nothing in the scenes has a right answer to fit to.
    """
    plain = setup.with_calibration(None)
    warm = replace(
        _untuned(plain, round(fit_temperature(lambda t: _loss_at(scenes, plain, task, t)), DIGITS)),
        label_set=plain.router.labeller.label_set.name,
        sha256=tuple(scene.questioned.sha256 for scene in scenes),
    )
    null = _null(questions_of(scenes, plain.with_calibration(warm).router))
    known = replace(warm, null=null)
    asked = questions_of(scenes, plain.with_calibration(known).router)
    tuned = tune_gate(decisions(asked), known.gate, setup.params.judge.min_claim)
    calibration = replace(known, gate=tuned)
    return Fitted(
        calibration=calibration,
        task=task,
        before=evaluate_calibration(scenes, plain),
        after=evaluate_calibration(scenes, plain.with_calibration(calibration)),
    )


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


def _null(asked: Sequence[Guess]) -> NullParams | None:
    """Return how probable "none of them" is; ``None`` without questions that tell."""
    present = np.array([one.has_answer for one in asked], np.bool_)
    if not len(present) or present.all() or not present.any():
        return None
    fitted = fit_null(np.array([one.evidence for one in asked]), present)
    return NullParams(round(fitted.scale, DIGITS), round(fitted.bias, DIGITS))


def _loss_at(scenes: Sequence[Scene], setup: Setup, task: str, temperature: float) -> float:
    """Return the mean over the fitted tasks of their losses at a temperature; NaN for none."""
    router = setup.with_calibration(_untuned(setup, temperature)).router
    asked = questions_of(scenes, router) if task != LABELS else []
    named = labels_of(scenes, router.labeller) if task != QUESTIONS else []
    losses = [part for part in (_question_losses(asked), _losses(named)) if len(part)]
    return float(np.mean([np.mean(part) for part in losses])) if losses else float("nan")


def _question_losses(asked: Sequence[Guess]) -> Float64:
    """Return the loss of each question, "none of them" being as probable as fits best.

    Only the questions with a right answer count where nothing else tells; of all, p of a thing is
    p of the thing, supposing that there is one, times p that there is.
    """
    null = _null(asked)
    if null is None:
        return _losses([one for one in asked if one.has_answer])
    known = [_judged(one, null.presence(one.evidence)) for one in asked]
    return _losses([one.with_null for one in known])


def _judged(guess: Guess, presence: float) -> Guess:
    """Return an uncalibrated guess with this presence."""
    return replace(guess, p=presence * guess.p, p_null=1.0 - presence)


def _losses(guesses: Sequence[Guess]) -> Float64:
    return np.array([log_loss(one.p, one.is_right) for one in guesses], np.float64)
