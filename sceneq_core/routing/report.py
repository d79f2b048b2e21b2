"""An answer in the form that was asked for: numbers, stamps and places beside the ranking."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from sceneq_core.mapping.delta import REMOVED
from sceneq_core.routing.answer import AMBIGUOUS, FOUND, NOT_FOUND, Answer, Match
from sceneq_core.routing.forms import COUNT, EXISTS, WHAT
from sceneq_core.routing.judge import Judge
from sceneq_core.routing.likelihood import Fit
from sceneq_core.routing.question import Question
from sceneq_core.routing.scene import SceneSnapshot
from sceneq_core.routing.tally import NOTHING, Counter, Tally
from sceneq_core.routing.whereabouts import Whereabouts, whereabouts

YES, NO, UNSURE = "yes", "no", "unsure"
LISTING = (COUNT, WHAT)
"""Forms that ask for all there are: their matches are no rivals."""


@dataclass(frozen=True, slots=True)
class Report:
    """``answer`` to a question of the form ``kind``.

    ``tally`` of what is counted or listed; ``exists`` is ``yes``, ``no`` or ``unsure``, "" where
    that is not asked; ``where`` the best match is, also one that only comes near. ``missing`` are
    the words for what is not there, "" = all is. ``gone``: what is meant was in the map once.
    """

    kind: str
    question: Question
    answer: Answer
    tally: Tally | None = None
    exists: str = ""
    where: Whereabouts | None = None
    missing: str = ""
    gone: Match | None = None

    @property
    def best(self) -> Match | None:
        """The first match, also where it is only the nearest miss."""
        return self.answer.matches[0] if self.answer.matches else None


class Reporter:
    """Reports on answers."""

    def __init__(self, judge: Judge, counter: Counter) -> None:
        self._judge = judge
        self._counter = counter

    def report(
        self,
        kind: str,
        snapshot: SceneSnapshot,
        question: Question,
        answer: Answer,
        fits: Mapping[str, Fit],
    ) -> Report:
        """Return the report on an answer that was given from ``snapshot``.

        ``fits`` says how well every thing of the question fits the instances; none in an empty map.
        """
        if not len(snapshot):
            exists = NO if kind == EXISTS else ""
            return Report(kind, question, answer, exists=exists, missing=_words(question))
        if kind not in (*LISTING, EXISTS) and answer.status != NOT_FOUND:
            return Report(kind, question, answer, where=_where(snapshot, answer))
        missing = self._missing(question, fits)
        tally = (
            self._counter.count(snapshot, question, fits) if kind in (*LISTING, EXISTS) else None
        )
        if tally is not None and kind in LISTING:
            answer = _listed(answer, tally, there=missing is None)
        return Report(
            kind=kind,
            question=question,
            answer=answer,
            tally=tally if missing is None else NOTHING,
            exists=self._existence(question, tally, missing, fits)
            if tally and kind == EXISTS
            else "",
            where=_where(snapshot, answer),
            missing="" if missing is None else missing or "thing",
        )

    def _missing(self, question: Question, fits: Mapping[str, Fit]) -> str | None:
        """Return what is surely not there of all that is spoken of."""
        target = question.phrase.target
        for words, fit in fits.items():
            if self._judge.absent(fit) if words == target else self._judge.missing(fit):
                return words
        return None

    def _existence(
        self, question: Question, tally: Tally, missing: str | None, fits: Mapping[str, Fit]
    ) -> str:
        """One thing alone may surely be there though it is not sure which instance it is.

        Not where it is described: that rooms have things to sit on says little of this one.
        """
        alone = len(fits) == 1
        if missing is not None:
            return NO
        target = question.phrase.target
        there = alone and not question.wanted[target].described
        if tally.sure or (there and self._judge.claims(fits[target].presence)):
            return YES
        return UNSURE if tally.possible or alone else NO


def gone_match(answer: Answer) -> Match | None:
    """Return the first match of a sure answer if it is gone from the map."""
    best = answer.matches[0] if answer.matches and answer.status == FOUND else None
    return best if best and best.instance.geometry.state == REMOVED else None


def _words(question: Question) -> str:
    return question.phrase.target or "thing"


def _where(snapshot: SceneSnapshot, answer: Answer) -> Whereabouts | None:
    return whereabouts(snapshot, answer.matches[0].instance) if answer.matches else None


def _listed(answer: Answer, tally: Tally, *, there: bool) -> Answer:
    """Return an answer whose matches are all those that are asked for."""
    if not there or not tally.matches:
        reason = "none of them fits the words and relations" if there else answer.reason
        return replace(answer, status=NOT_FOUND, reason=reason)
    reason = f"{len(tally.sure)} sure, {len(tally.possible)} possible: each judged by itself"
    status = FOUND if tally.sure else AMBIGUOUS
    return replace(answer, status=status, matches=tally.matches, reason=reason)
