"""A reasoner that looks: fetches the keyframes it needs, asks a model, weighs the replies."""

import time
from collections.abc import Callable, Sequence
from typing import TypeVar

from sceneq_core.arrays import UInt8
from sceneq_core.reasoning import visual
from sceneq_core.reasoning.explanation import no_candidates
from sceneq_core.reasoning.multiple_choice import NONE, VisualQuestion
from sceneq_core.reasoning.numbered_boxes import covering_views
from sceneq_core.reasoning.reasoner import (
    LabelProblem,
    LabelVerdict,
    Pictures,
    Problem,
    UnansweredError,
    Verdict,
    Views,
    no_pictures,
)
from sceneq_core.reasoning.visual import VisualParams
from sceneq_nodes._timed_calls import left
from sceneq_nodes._vision_model import Replies, VisionModel

T = TypeVar("T")

LONGEST_S = 600.0
SHARE_KEPT, MOST_KEPT_S = 0.1, 0.5
"""Of the asker's time, for the way back of the verdict."""


class VisualReasoner:
    """Both directions with one ``model``; docs/reasoners.md."""

    def __init__(self, params: VisualParams, model: VisionModel) -> None:
        self._params = params
        self._model = model

    def solve(self, problem: Problem, pictures: Pictures = no_pictures) -> Verdict:
        """Ask which numbered box is meant, in one call with few pictures.

        Raises:
            UnansweredError: no picture, no reply in time, none that can be used, or not allowed.
        """
        _need_to_spend(problem)
        end_s = _end_s(problem.time_s)
        targets = [c for c in problem.candidates if c.role == "target"]
        if not targets:
            return Verdict((), no_candidates(problem), 0)
        views = [c.views for c in targets]
        most = self._params.max_views
        seen = _fetch(views, lambda there: covering_views(there, most), pictures, end_s)
        shown = _possible(lambda: visual.show_candidates(problem.text, targets, seen, self._params))
        replies = self._model.ask([shown.question], end_s)
        choices = _choices(shown.question, replies)
        return Verdict(
            visual.instance_ranking(shown, targets, choices, self._params),
            self._why_instance(shown, [c.instance_id for c in targets], choices),
            replies.vlm_calls,
            replies.usage,
        )

    def label(self, problem: LabelProblem, pictures: Pictures = no_pictures) -> LabelVerdict:
        """Ask what the thing is called, one call for every view at once; the majority decides.

        Raises:
            UnansweredError: as ``solve``.
        """
        _need_to_spend(problem)
        end_s = _end_s(problem.time_s)
        most = self._params.label_views
        seen = _fetch([problem.views], lambda there: _first_seqs(there[0], most), pictures, end_s)
        questions = _possible(lambda: visual.show_thing(problem, seen, self._params))
        replies = self._model.ask(questions, end_s)
        choices = _choices(questions[0], replies)
        ranking = visual.label_ranking(problem, choices, self._params)
        voted = [problem.labels[int(key) - 1][0] for key in choices]
        best = ranking[0][0]
        return LabelVerdict(
            ranking,
            f"{voted.count(best)} of {len(questions)} views say '{best}' ({self._model.name})",
            replies.vlm_calls,
            replies.usage,
        )

    def close(self) -> None:
        """Release the model."""
        self._model.close()

    def _why_instance(self, shown: visual.Shown, ids: Sequence[int], choices: Sequence[str]) -> str:
        said = [
            "none of the boxes" if key == NONE else f"instance {ids[shown.rows[int(key) - 1]]}"
            for key in choices
        ]
        unseen = len(ids) - len(shown.rows)
        beside = f"; {unseen} of {len(ids)} candidates could not be shown" if unseen else ""
        pictures = len(shown.question.pictures)
        where = f"{pictures} picture{'s' if pictures > 1 else ''}"
        return f"{self._model.name} chose {' and '.join(said)} in {where}{beside}"


def _fetch(
    views: Sequence[Views],
    choose: Callable[[Sequence[Views]], tuple[int, ...]],
    pictures: Pictures,
    end_s: float,
) -> dict[int, UInt8]:
    """Return the chosen keyframes by seq; others take the place of those that are gone.

    Raises:
        UnansweredError: there is none, or no time to fetch them.
    """
    known: dict[int, UInt8 | None] = {}
    while True:
        there = [
            tuple(v for v in of_thing if v[0] not in known or known[v[0]] is not None)
            for of_thing in views
        ]
        chosen = choose(there)
        missing = [seq for seq in chosen if seq not in known]
        if not chosen:
            raise UnansweredError("no keyframe to look at")
        if not missing:
            return {seq: rgb for seq in chosen if (rgb := known[seq]) is not None}
        if not left(end_s):
            raise UnansweredError("no time left to look")
        known |= {seq: pictures(seq, left(end_s)) for seq in missing}


def _need_to_spend(problem: Problem | LabelProblem) -> None:
    if not problem.may_spend:
        raise UnansweredError("a call of a model is not allowed now")


def _end_s(time_s: float) -> float:
    """Return when the model must have answered, on the clock ``time.monotonic``."""
    time_s = min(time_s, LONGEST_S)
    return time.monotonic() + time_s - min(SHARE_KEPT * time_s, MOST_KEPT_S)


def _first_seqs(views: Views, most: int) -> tuple[int, ...]:
    return tuple(dict.fromkeys(seq for seq, _ in views))[:most]


def _choices(question: VisualQuestion, replies: Replies) -> list[str]:
    """Return the choices that were made; replies that make none are no votes."""
    choices, problems = visual.read_choices(question, replies.texts)
    if not choices:
        why = "; ".join(dict.fromkeys((*replies.failures, *problems)))
        raise UnansweredError(why, replies.vlm_calls, replies.usage)
    return choices


def _possible(show: Callable[[], T]) -> T:
    """Return the question; a thing that no picture shows cannot be asked about."""
    try:
        return show()
    except ValueError as error:
        raise UnansweredError(str(error)) from error
