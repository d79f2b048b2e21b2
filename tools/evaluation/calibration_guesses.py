"""First guesses with the probabilities behind them, in the two directions of the router."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sceneq_core.arrays import Bool, Float64
from sceneq_core.evaluation.gate_decisions import Decisions
from sceneq_core.evaluation.proper_scores import LEAST_P
from sceneq_core.routing.gate import Confidence
from sceneq_core.routing.labels import Labeller
from sceneq_core.routing.null import NO_EVIDENCE, Evidence
from sceneq_core.routing.router import Router
from sceneq_tools.evaluation.retrieval_candidates import Candidates
from sceneq_tools.evaluation.retrieval_queries import Query
from sceneq_tools.evaluation.true_things import TrueThing


@dataclass(frozen=True, slots=True, eq=False)
class Guess:
    """A distribution ``p`` (C,) over the choices of ``what``, and which ``is_right`` (C,).

    ``p_null`` is what is left to "none of them", which is right when no choice is; ``absence`` is
    the same without a calibration, only good to compare. ``evidence`` is what it is judged by.
    ``described``: the words describe a thing and do not name it.
    """

    what: str
    p: Float64
    is_right: Bool
    p_null: float = 0.0
    absence: float = 0.0
    evidence: Evidence = NO_EVIDENCE
    described: bool = False

    @property
    def has_answer(self) -> bool:
        """Whether any choice is right."""
        return bool(self.is_right.any())

    @property
    def is_top_right(self) -> bool:
        """Whether the most probable choice is right; of equal ones the first counts."""
        return bool(self.is_right[int(np.argmax(self.p))])

    @property
    def supposing(self) -> "Guess":
        """The same on the supposition that there is one."""
        return replace(self, p=self.p / max(1.0 - self.p_null, LEAST_P), p_null=0.0)

    @property
    def with_null(self) -> "Guess":
        """The same with "none of them" as the last choice."""
        return Guess(
            what=self.what,
            p=np.append(self.p, self.p_null),
            is_right=np.append(self.is_right, not self.has_answer),
            described=self.described,
        )


def question_guesses(
    router: Router,
    candidates: Candidates,
    queries: Iterable[Query],
    reader: Router | None = None,
) -> list[Guess]:
    """Return for every question the probability of each candidate, and of none, to be meant.

    Questions with a relation are left out: the encoder's first guess never decides those.
    ``reader``: a router of the same words that remembers the questions, when many are tried.
    """
    ids = [one.instance_id for one in candidates.snapshot.instances]
    guesses = []
    for query in queries:
        question = (reader or router).read(query.text)
        if question.phrase.constraints or not ids:
            continue
        fit = router.fits(candidates.snapshot, question)[question.phrase.target]
        guesses.append(
            Guess(
                what=query.text,
                p=(1.0 - fit.p_null) * fit.p,
                is_right=np.isin(ids, right_candidates(candidates, query)),
                p_null=fit.p_null,
                absence=1.0 - fit.presence,
                evidence=fit.evidence,
                described=question.wanted[question.phrase.target].described,
            )
        )
    return guesses


def label_guesses(
    labeller: Labeller, candidates: Candidates, things: Iterable[TrueThing]
) -> list[Guess]:
    """Return for every true thing among the candidates the probability of each label.

    Things whose names are all outside the label set are left out.
    """
    labels = [label.lower() for label in labeller.label_set.labels]
    named = {thing.id: {name.lower() for name in thing.names} for thing in things}
    scores = labeller.scores(np.asarray(candidates.snapshot.descriptors))
    guesses = []
    for instance, row in zip(candidates.snapshot.instances, scores, strict=True):
        names = named[instance.instance_id]
        is_right = np.array([label in names for label in labels])
        if is_right.any():
            guesses.append(Guess("/".join(sorted(names)), labeller.distribution(row), is_right))
    return guesses


def decisions(guesses: Sequence[Guess]) -> Decisions:
    """Return what the gate sees of the guesses."""
    seen = [Confidence.of(guess.p, 1.0, guess.p_null) for guess in guesses]
    return Decisions(
        p_max=np.array([one.p_max for one in seen], np.float64),
        margin=np.array([one.margin for one in seen], np.float64),
        entropy_norm=np.array([one.entropy_norm for one in seen], np.float64),
        right=np.array([guess.is_top_right for guess in guesses], np.bool_),
    )


def right_candidates(candidates: Candidates, query: Query) -> list[int]:
    """Return the candidates that are what is asked for, by their first rule of a hit."""
    matches = next(iter(candidates.matches.values()))
    return [one for target in sorted(query.targets) for one in matches.get(target, ())]
