"""How many there are, and which: every instance judged by itself, not against the others."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from sceneq_core.arrays import Int64
from sceneq_core.reasoning.geometric import GeometricParams, GeometricReasoner
from sceneq_core.reasoning.reasoner import Problem
from sceneq_core.routing.answer import Match
from sceneq_core.routing.candidates import pose_problem
from sceneq_core.routing.likelihood import Fit
from sceneq_core.routing.matches import MAX_MATCHES
from sceneq_core.routing.mixture import Fitting
from sceneq_core.routing.named_fit import with_name_each
from sceneq_core.routing.question import Question, Wanted
from sceneq_core.routing.scene import SceneSnapshot

POSSIBLE = 0.1
"""Below this probability an instance is not even possibly one of those asked for, unless it is
called so all the same: the count must not contradict the labels."""

ANCHORS = 3
"""Of the things that an anchor may be, the likeliest are looked at."""


@dataclass(frozen=True, slots=True)
class Tally:
    """What is asked for: ``sure`` with at least the probability of a claim, else ``possible``.

    The ``p`` of a match is the probability that it is one of them, most probable first;
    ``expected`` is the sum of all: the mean of their number, if they were independent.
    """

    sure: tuple[Match, ...]
    possible: tuple[Match, ...]
    expected: float

    @property
    def matches(self) -> tuple[Match, ...]:
        """All of them, the most probable first."""
        return (*self.sure, *self.possible)


NOTHING = Tally((), (), 0.0)


class Counter:
    """Counts instances by what the encoder says of each and by the geometry of the map."""

    def __init__(self, likelihood: Fitting, min_claim: float) -> None:
        self._likelihood = likelihood
        self._min_claim = min_claim
        self._geometry = GeometricReasoner(GeometricParams())

    def count(self, snapshot: SceneSnapshot, question: Question, fits: Mapping[str, Fit]) -> Tally:
        """Return those among the ``MAX_MATCHES`` likeliest that fit words and relations."""
        target = fits[question.phrase.target]
        rows, holds = self._holding(snapshot, question, fits)
        wanted = question.wanted[question.phrase.target]
        p = self._likelihood.each(snapshot, wanted, rows)
        given = snapshot.names.meant(question.phrase.target, question.text)
        p = with_name_each(p, rows, given) if given else p
        so_called = [_is_called(snapshot, int(row), wanted) for row in rows]
        possible = np.where(so_called, np.minimum(p, POSSIBLE), POSSIBLE)
        p = p * [holds.get(snapshot.instances[row].instance_id, 1.0) for row in rows]
        p = p * _presence_of_anchors(question, fits)
        order = np.argsort(-p, kind="stable")
        found = [
            Match(snapshot.instances[rows[i]], float(p[i]), float(target.cosine[rows[i]]))
            for i in order
            if p[i] >= possible[i]
        ]
        sure = tuple(one for one in found if one.p >= self._min_claim)
        return Tally(sure, tuple(found[len(sure) :]), float(sum(one.p for one in found)))

    def _holding(
        self, snapshot: SceneSnapshot, question: Question, fits: Mapping[str, Fit]
    ) -> tuple[Int64, dict[int, float]]:
        """Return the rows to look at, and how well all relations hold for them by id."""
        rows = fits[question.phrase.target].order[:MAX_MATCHES]
        if not question.phrase.constraints:
            return rows, {}
        problem = pose_problem(snapshot, question, fits, MAX_MATCHES)
        if problem is None:
            return rows[:0], {}
        holds = self._geometry.holds(_with_few_anchors(problem))
        found = [snapshot.find(instance_id) for instance_id in holds]
        rows = np.array([row for row in found if row is not None], np.int64)
        return rows, holds


def _presence_of_anchors(question: Question, fits: Mapping[str, Fit]) -> float:
    """Nothing is surer to be on a table than that there is a table."""
    anchors = {words for one in question.phrase.constraints for words in one.things}
    return min((fits[words].presence for words in anchors if words in fits), default=1.0)


def _is_called(snapshot: SceneSnapshot, row: int, wanted: Wanted) -> bool:
    """Whether the label of an instance is what is asked for, or a kind of it."""
    if not wanted.noun or wanted.colours or wanted.excluded or wanted.sizes:
        return False
    return f" {snapshot.instances[row].label.name}".endswith(f" {wanted.noun}")


def _with_few_anchors(problem: Problem) -> Problem:
    """Return the problem with the ``ANCHORS`` likeliest candidates of every other thing."""
    kept, seen = [], dict.fromkeys((c.words for c in problem.candidates), 0)
    for candidate in problem.candidates:
        seen[candidate.words] += candidate.role == "anchor"
        if candidate.role == "target" or seen[candidate.words] <= ANCHORS:
            kept.append(candidate)
    return replace(problem, candidates=tuple(kept))
