"""From a question to an answer: at once when the encoder is sure, by a reasoner when not."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from sceneq_core.checks import need_within
from sceneq_core.encoding.encoder import Encoder
from sceneq_core.reasoning.reasoner import (
    NO_USAGE,
    LabelProblem,
    LabelVerdict,
    Problem,
    Usage,
    Verdict,
)
from sceneq_core.routing.answer import (
    AMBIGUOUS,
    FALLBACK,
    FAST,
    FOUND,
    NOT_FOUND,
    REASONED,
    Answer,
    Match,
    Naming,
)
from sceneq_core.routing.candidates import pose_problem
from sceneq_core.routing.gate import Confidence
from sceneq_core.routing.judge import Judge, JudgeParams, absence, hesitation
from sceneq_core.routing.labels import Label, Labeller
from sceneq_core.routing.likelihood import Fit, Likelihood
from sceneq_core.routing.question import Question, Reader, TextTower
from sceneq_core.routing.scene import SceneSnapshot

MAX_MATCHES = 50


@dataclass(frozen=True, slots=True)
class RouterParams:
    """``top_k``: candidates for the reasoner.

    ``synonym_cosine``: labels whose text is this close to the words mean the same thing and do
    not compete with them.
    """

    judge: JudgeParams = field(default_factory=JudgeParams)
    top_k: int = 10
    synonym_cosine: float = 0.8

    def __post_init__(self) -> None:
        need_within(self, 1, MAX_MATCHES, "top_k")
        need_within(self, -1, 1, "synonym_cosine")


@dataclass(frozen=True, slots=True)
class Routed:
    """The encoder's answer, whether it is ``enough``, and the problem for a reasoner if it is not.

    ``presence`` is the least of all things that are spoken of, anchors included. There is no
    problem in an empty map.
    """

    answer: Answer
    enough: bool
    presence: float
    problem: Problem | None


class Router:
    """Both directions: text to instance (``answer``), instance to label (``label``).

    The fast path asks the encoder alone; docs/adr/0004-bold-or-ambiguous.md says why its gate
    leaves so much to a reasoner.
    """

    def __init__(self, params: RouterParams, encoder: Encoder, labeller: Labeller) -> None:
        tower = TextTower(encoder)
        self.params = params
        self.labeller = labeller
        self._temperature = encoder.temperature
        self._judge = Judge(params.judge)
        self._reader = Reader(tower, labeller, params.synonym_cosine)
        self._likelihood = Likelihood(tower, encoder.temperature, encoder.ceiling)

    def read(self, text: str) -> Question:
        """Return the question in ``text``: the only step that runs the text tower.

        Raises:
            ValueError: empty or too long.
        """
        return self._reader.read(text)

    def answer(self, snapshot: SceneSnapshot, question: Question) -> Routed:
        """Answer from the descriptors, and say whether a reasoner should look at it."""
        if not len(snapshot):
            return Routed(_empty(snapshot, question), enough=True, presence=0.0, problem=None)
        # s = cos(instance, words) and p = softmax(s / T), for the target and every anchor.
        fits = self.fits(snapshot, question)
        target = fits[question.phrase.target]
        # The gate: p_max, margin and normalised entropy of the target's p.
        confidence = Confidence.of(target.p, self._temperature)
        status, reason = self._decide(question, fits, confidence)
        answer = Answer(
            status=status,
            question=question.text,
            matches=_matches(snapshot, target),
            confidence=confidence,
            presence=target.presence,
            route=FAST,
            reason=reason,
            vlm_calls=0,
            revision=snapshot.revision,
        )
        # What does not pass goes to a reasoner, as the top K candidates.
        return Routed(
            answer=answer,
            enough=status != AMBIGUOUS,
            presence=min(fit.presence for fit in fits.values()),
            problem=pose_problem(snapshot, question, fits, self.params.top_k),
        )

    def fits(self, snapshot: SceneSnapshot, question: Question) -> dict[str, Fit]:
        """Return how well every thing a question speaks of fits the instances; one at least."""
        wanted = question.wanted.items()
        return {words: self._likelihood.fit(snapshot, thing) for words, thing in wanted}

    def conclude(self, snapshot: SceneSnapshot, routed: Routed, verdict: Verdict) -> Answer:
        """Return the reasoner's answer; it may be bold only where the encoder knows the thing.

        Raises:
            ValueError: the verdict ranks an instance that was not among the candidates.
        """
        fast = routed.answer
        told = replace(
            fast,
            route=REASONED,
            reason=verdict.reason,
            vlm_calls=verdict.vlm_calls,
            usage=verdict.usage,
        )
        if not verdict.ranking:
            sure = self._judge.claims(routed.presence)
            return replace(told, status=NOT_FOUND if sure else AMBIGUOUS)
        confidence = Confidence.of(np.array([p for _, p in verdict.ranking]), self._temperature)
        known = self._judge.claims(routed.presence, confidence.p_max)
        sure = known and self._judge.accepts(confidence)
        doubt = "" if known else "; but the encoder is not sure that these are such things"
        return replace(
            told,
            reason=verdict.reason + doubt,
            status=FOUND if sure else AMBIGUOUS,
            matches=tuple(_ranked(snapshot, routed.problem, verdict.ranking)),
            confidence=confidence,
        )

    def fall_back(
        self, routed: Routed, why: str, vlm_calls: int = 0, usage: Usage = NO_USAGE
    ) -> Answer:
        """Return the encoder's answer, marked: a reasoner should have looked, but ``why``."""
        fast = routed.answer
        reason = f"{why}; {fast.reason}"
        return replace(fast, route=FALLBACK, reason=reason, vlm_calls=vlm_calls, usage=usage)

    def label(self, snapshot: SceneSnapshot, row: int, k: int = 5) -> Naming:
        """Return what the instance in ``row`` is called, and whether the gate accepts it."""
        scores = snapshot.label_scores[row]
        confidence = Confidence.of(self.labeller.distribution(scores), self._temperature)
        accepted = self._judge.accepts(confidence)
        return Naming(
            status=FOUND if accepted else AMBIGUOUS,
            instance=snapshot.instances[row],
            labels=self.labeller.best_of_scores(scores, k),
            confidence=confidence,
            reason="the gate accepts the label" if accepted else hesitation(confidence),
            revision=snapshot.revision,
        )

    def label_problem(self, snapshot: SceneSnapshot, row: int) -> LabelProblem:
        """Return the question for a reasoner what the instance in ``row`` is called."""
        best = self.labeller.best_of_scores(snapshot.label_scores[row], self.params.top_k)
        instance = snapshot.instances[row]
        views = tuple((view.seq, view.box_xyxy) for view in instance.views)
        labels = tuple((label.name, label.p) for label in best)
        return LabelProblem(instance.instance_id, labels, views)

    def conclude_label(
        self, snapshot: SceneSnapshot, row: int, verdict: LabelVerdict, k: int = 5
    ) -> Naming:
        """Return the reasoner's name: it has seen the thing, so its own votes carry the claim.

        Raises:
            ValueError: no label, or one that the encoder did not propose.
        """
        if not verdict.ranking:
            raise ValueError("verdict: no label")
        naming = self.label(snapshot, row, self.params.top_k)
        confidence = Confidence.of(np.array([p for _, p in verdict.ranking]), self._temperature)
        cosine = {label.name: label.cosine for label in naming.labels}
        if unknown := [name for name, _ in verdict.ranking if name not in cosine]:
            raise ValueError(f"verdict: {unknown[0]!r:.40} was not proposed")
        return replace(
            naming,
            status=FOUND if self._judge.accepts(confidence) else AMBIGUOUS,
            labels=tuple(Label(name, p, cosine[name]) for name, p in verdict.ranking[:k]),
            confidence=confidence,
            reason=verdict.reason,
            route=REASONED,
            vlm_calls=verdict.vlm_calls,
            usage=verdict.usage,
        )

    def fall_back_label(
        self, naming: Naming, why: str, vlm_calls: int = 0, usage: Usage = NO_USAGE
    ) -> Naming:
        """Return the encoder's name, marked as in ``fall_back``."""
        reason = f"{why}; {naming.reason}"
        return replace(naming, route=FALLBACK, reason=reason, vlm_calls=vlm_calls, usage=usage)

    def _decide(
        self, question: Question, fits: Mapping[str, Fit], confidence: Confidence
    ) -> tuple[str, str]:
        """Judge the target; the encoder cannot be sure of a relation, only of a missing anchor."""
        target, constraints = question.phrase.target, question.phrase.constraints
        for words in (c.anchor for c in constraints if c.anchor):
            if self._judge.absent(fits[words]):
                return NOT_FOUND, absence(words)
        status, reason = self._judge.judge(target or "anything", fits[target], confidence)
        if constraints and status != NOT_FOUND:
            return AMBIGUOUS, f"ranked by '{target or 'anything'}' only, {_left_out(question)}"
        return status, reason


def _empty(snapshot: SceneSnapshot, question: Question) -> Answer:
    seen = snapshot.instance_count
    return Answer(
        status=NOT_FOUND,
        question=question.text,
        matches=(),
        confidence=Confidence.of(np.zeros(0), 1.0),
        presence=0.0,
        route=FAST,
        reason=f"the map is empty: {seen} instances, none with a descriptor yet",
        vlm_calls=0,
        revision=snapshot.revision,
    )


def _matches(snapshot: SceneSnapshot, fit: Fit) -> tuple[Match, ...]:
    p = fit.p
    return tuple(
        Match(snapshot.instances[row], float(p[row]), float(fit.cosine[row]))
        for row in fit.order[:MAX_MATCHES].tolist()
    )


def _ranked(
    snapshot: SceneSnapshot, problem: Problem | None, ranking: Iterable[tuple[int, float]]
) -> Iterable[Match]:
    """Yield the matches of a ranking, evidence and cosine from the problem it solves."""
    targets = [c for c in problem.candidates if c.role == "target"] if problem else []
    cosine = {c.instance_id: c.cosine for c in targets}
    for instance_id, p in ranking:
        row = snapshot.find(instance_id)
        if row is None or instance_id not in cosine:
            raise ValueError(f"verdict: instance {instance_id} was not a candidate")
        yield Match(snapshot.instances[row], p, cosine[instance_id])


def _left_out(question: Question) -> str:
    """Say what the encoder alone did not look at."""
    asked = (f"'{c.relation} {c.anchor}'".replace(" '", "'") for c in question.phrase.constraints)
    return f"without {' and '.join(asked).replace('_', ' ')}"
