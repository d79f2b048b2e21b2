"""Temperature and thresholds for one encoder, fitted on recordings that nothing else is told of."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sceneq_core.evaluation.gate_tuning import tune_gate
from sceneq_core.evaluation.proper_scores import log_loss
from sceneq_core.evaluation.temperature import fit_temperature
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
    """Fit T by the mean negative log-likelihood of ``task``, then the gate by F1 on questions.

    Raises:
        ValueError: nothing in the scenes has a right answer to fit to.
    """
    guesses_at = _guesses(scenes, setup, task)
    temperature = round(fit_temperature(lambda t: _loss(guesses_at(t))), DIGITS)
    gate = setup.router.params.judge.gate
    warm = setup.with_calibration(Calibration(setup.encoder.model_id, temperature, gate))
    tuned = tune_gate(decisions(questions_of(scenes, warm.router)), gate)
    calibration = Calibration(
        encoder=setup.encoder.model_id,
        temperature=temperature,
        gate=tuned,
        sha256=tuple(scene.questioned.sha256 for scene in scenes),
    )
    return Fitted(
        calibration=calibration,
        task=task,
        before=evaluate_calibration(scenes, setup),
        after=evaluate_calibration(scenes, setup.with_calibration(calibration)),
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


def _guesses(
    scenes: Sequence[Scene], setup: Setup, task: str
) -> Callable[[float], list[list[Guess]]]:
    """Return what makes the guesses of each fitted task at a temperature."""
    gate = setup.router.params.judge.gate

    def guesses_at(temperature: float) -> list[list[Guess]]:
        calibration = Calibration(setup.encoder.model_id, temperature, gate)
        router = setup.with_calibration(calibration).router
        asked = questions_of(scenes, router) if task != LABELS else []
        named = labels_of(scenes, router.labeller) if task != QUESTIONS else []
        return [[one for one in part if one.has_answer] for part in (asked, named)]

    return guesses_at


def _loss(parts: Sequence[Sequence[Guess]]) -> float:
    """Return the mean over tasks of the mean over guesses; NaN when there are none."""
    losses = [np.mean([log_loss(one.p, one.is_right) for one in part]) for part in parts if part]
    return float(np.mean(losses)) if losses else float("nan")
