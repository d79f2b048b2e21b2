"""From a question to an answer: at once when the encoder is sure, by a reasoner when not."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, partial

import numpy as np

from sceneq_core.checks import need_within
from sceneq_core.encoding.encoder import Encoder
from sceneq_core.reasoning.reasoner import NO_USAGE, Problem, Usage, Verdict
from sceneq_core.routing.answer import (
    AMBIGUOUS,
    FALLBACK,
    FAST,
    FOUND,
    NOT_FOUND,
    REASONED,
    Answer,
)
from sceneq_core.routing.candidates import pose_problem
from sceneq_core.routing.gate import Confidence
from sceneq_core.routing.judge import Judge, JudgeParams, absence
from sceneq_core.routing.labels import Labeller
from sceneq_core.routing.likelihood import Fit, Likelihood
from sceneq_core.routing.matches import MAX_MATCHES, matches_of_fit, matches_of_ranking
from sceneq_core.routing.mixture import Fitting, Mixture
from sceneq_core.routing.named_fit import judged_by_name, with_name
from sceneq_core.routing.namer import Namer, OtherLabels
from sceneq_core.routing.names import GivenName
from sceneq_core.routing.null import NullParams
from sceneq_core.routing.picture import PictureMatcher
from sceneq_core.routing.question import Question, Reader, TextTower
from sceneq_core.routing.report import Reporter
from sceneq_core.routing.scene import SceneSnapshot
from sceneq_core.routing.sureness import Sureness
from sceneq_core.routing.tally import Counter
from sceneq_core.routing.unfamiliar import Unfamiliar


@dataclass(frozen=True, slots=True)
class RouterParams:
    """``top_k``: candidates for the reasoner.

    ``synonym_cosine``: labels whose text is this close to the words mean the same thing and do
    not compete with them. ``null``: how probable "none of them" is; a calibration knows.
    ``null_described``: the same where words describe a thing rather than name it, ``None`` = alike;
    ``sureness_described``: how sure the first guess then is, ``None`` = as the softmax says.
    ``unfamiliar``: all this where things look strange to the encoder, ``None`` = alike.
    """

    judge: JudgeParams = field(default_factory=JudgeParams)
    null: NullParams | None = None
    null_described: NullParams | None = None
    sureness_described: Sureness | None = None
    unfamiliar: Unfamiliar | None = None
    top_k: int = 10
    synonym_cosine: float = 0.8

    def __post_init__(self) -> None:
        need_within(self, 1, MAX_MATCHES, "top_k")
        need_within(self, -1, 1, "synonym_cosine")


@dataclass(frozen=True, slots=True)
class Routed:
    """The encoder's answer, whether it is ``enough``, and the problem for a reasoner if it is not.

    ``presence`` is the least of all things that are spoken of, anchors included. ``pose`` returns
    the problem; there is none in an empty map. ``fits`` says how well every thing that is spoken of
    fits the instances.
    """

    answer: Answer
    enough: bool
    presence: float
    pose: Callable[[], Problem | None]
    fits: Mapping[str, Fit] = field(default_factory=dict)

    @property
    def problem(self) -> Problem | None:
        """The problem, made once and only if somebody wants it."""
        return self.pose()


class Router:
    """Both directions: text to instance (``answer``), instance to label (``namer``).

    The fast path asks the encoder alone; docs/adr/0004-bold-or-ambiguous.md says why its gate
    leaves so much to a reasoner.
    """

    def __init__(
        self,
        params: RouterParams,
        encoder: Encoder,
        labeller: Labeller,
        calibration: str = "none",
    ) -> None:
        """``calibration`` names what temperature, gate and null are from."""
        tower = TextTower(encoder)
        self.params = params
        self.labeller = labeller
        self.calibration = calibration
        self._temperature = encoder.temperature
        self._judge = Judge(params.judge)
        self.namer = Namer(labeller, self._judge, encoder.temperature, params.top_k)
        self.other_labels = OtherLabels(self.namer, encoder)
        self._reader = Reader(tower, labeller, params.synonym_cosine)
        self._likelihood = _likelihood(tower, encoder, params)
        counter = Counter(self._likelihood, params.judge.min_claim)
        self.pictures = PictureMatcher(labeller, self._judge, encoder.temperature)
        self.reporter = Reporter(self._judge, counter)

    def read(self, text: str, *, many: bool = False) -> Question:
        """Return the question in ``text``: the only step that runs the text tower.

        ``many``: it speaks of its target in the plural.

        Raises:
            ValueError: empty or too long.
        """
        return self._reader.read(text, many=many)

    def answer(self, snapshot: SceneSnapshot, question: Question) -> Routed:
        """Answer from the descriptors, and say whether a reasoner should look at it."""
        if not len(snapshot):
            return Routed(_empty(snapshot, question), enough=True, presence=0.0, pose=lambda: None)
        # s = cos(instance, words) and p = softmax(s / T), for the target and every anchor.
        fits = self.fits(snapshot, question)
        target = fits[question.phrase.target]
        # One more candidate: none of them, when the target or an anchor is not there.
        p_null = max(fit.p_null for fit in fits.values())
        # The gate: p_max, margin and normalised entropy of the target's p.
        confidence = Confidence.of((1.0 - p_null) * target.p, self._temperature, p_null)
        given = snapshot.names.meant(question.phrase.target, question.text)
        status, reason = self._decide(question, fits, confidence, given)
        answer = Answer(
            status=status,
            question=question.text,
            matches=matches_of_fit(snapshot, target, p_null),
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
            pose=cache(partial(pose_problem, snapshot, question, fits, self.params.top_k)),
            fits=fits,
        )

    def fits(self, snapshot: SceneSnapshot, question: Question) -> dict[str, Fit]:
        """Return how well every thing a question speaks of fits the instances; one at least."""
        fits = {}
        for words, thing in question.wanted.items():
            fit = self._likelihood.fit(snapshot, thing)
            given = snapshot.names.meant(words, question.text)
            fits[words] = with_name(fit, given) if given else fit
        return fits

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
            vlm_calls=verdict.billed[0],
            usage=verdict.billed[1],
            cached=verdict.cached,
        )
        if not verdict.ranking:
            sure = fast.status == NOT_FOUND or self._judge.claims(routed.presence)
            return replace(told, status=NOT_FOUND if sure else AMBIGUOUS)
        p_null = fast.confidence.p_null
        ranking = [(one, (1.0 - p_null) * p) for one, p in verdict.ranking]
        confidence = Confidence.of(np.array([p for _, p in ranking]), self._temperature, p_null)
        known = self._judge.claims(routed.presence, max(p for _, p in verdict.ranking))
        sure = known and self._judge.accepts(confidence)
        doubt = "" if known else "; but the encoder is not sure that these are such things"
        # Who has not looked cannot tell that there is one after all.
        absent = fast.status == NOT_FOUND and not verdict.vlm_calls
        return replace(
            told,
            reason=verdict.reason + doubt,
            status=NOT_FOUND if absent else FOUND if sure else AMBIGUOUS,
            matches=tuple(matches_of_ranking(snapshot, routed.problem, ranking)),
            confidence=confidence,
        )

    def fall_back(
        self, routed: Routed, why: str, vlm_calls: int = 0, usage: Usage = NO_USAGE
    ) -> Answer:
        """Return the encoder's answer, marked: a reasoner should have looked, but ``why``."""
        fast = routed.answer
        reason = f"{why}; {fast.reason}"
        return replace(fast, route=FALLBACK, reason=reason, vlm_calls=vlm_calls, usage=usage)

    def _decide(
        self,
        question: Question,
        fits: Mapping[str, Fit],
        confidence: Confidence,
        given: GivenName | None,
    ) -> tuple[str, str]:
        """Judge the target; the encoder cannot be sure of a relation, only of a missing anchor.

        ``given`` is the taught name that the target is, if it is one.
        """
        target, constraints = question.phrase.target, question.phrase.constraints
        for words in (words for c in constraints for words in c.things):
            if self._judge.missing(fits[words]):
                return NOT_FOUND, absence(words, fits[words])
        status, reason = self._judge.judge(target or "anything", fits[target], confidence)
        if given is not None:
            status, reason = judged_by_name(given, self._judge, confidence, (status, reason))
        if constraints and status != NOT_FOUND:
            return AMBIGUOUS, f"ranked by '{target or 'anything'}' only, {_left_out(question)}"
        return status, reason


def _likelihood(tower: TextTower, encoder: Encoder, params: RouterParams) -> Fitting:
    """Return the likelihood of a calibration, or the mixture of its two."""
    nulls = params.null, params.null_described, params.sureness_described
    familiar = Likelihood(tower, encoder.temperature, encoder.ceiling, *nulls)
    strange = params.unfamiliar
    if strange is None:
        return familiar
    nulls = strange.null, strange.null_described, strange.sureness_described
    unfamiliar = Likelihood(tower, strange.temperature, encoder.ceiling, *nulls)
    return Mixture(familiar, unfamiliar, strange)


def _empty(snapshot: SceneSnapshot, question: Question) -> Answer:
    seen = snapshot.instance_count
    return Answer(
        status=NOT_FOUND,
        question=question.text,
        matches=(),
        confidence=Confidence.of(np.zeros(0), 1.0, 1.0),
        presence=0.0,
        route=FAST,
        reason=f"the map is empty: {seen} instances, none with a descriptor yet",
        vlm_calls=0,
        revision=snapshot.revision,
    )


def _left_out(question: Question) -> str:
    """Say what the encoder alone did not look at."""
    asked = (f"'{c.relation} {c.anchor}'".replace(" '", "'") for c in question.phrase.constraints)
    return f"without {' and '.join(asked).replace('_', ' ')}"
