"""Does a question find its thing? Hit@1 and Hit@5 per bucket of questions."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from sceneq_core.evaluation.ranking import hit_at
from sceneq_core.reasoning.reasoner import Pictures, no_pictures
from sceneq_core.routing.answer import FALLBACK, FAST, REASONED
from sceneq_tools.evaluation.retrieval_asking import SELECTIVE, Answered, Asking
from sceneq_tools.evaluation.retrieval_candidates import Candidates, Matches
from sceneq_tools.evaluation.retrieval_queries import BUCKETS, Query
from sceneq_tools.evaluation.retrieval_setup import Setup

PROTOCOL = (
    "hit@k: one of the k best matches is a target, whatever the status; "
    "absent questions: right = the answer is not_found"
)
PRESENT, ALL = "present", "all"


@dataclass(frozen=True, slots=True)
class BucketScore:
    """How the questions of one bucket were answered; counts, and the median time in ms.

    ``hit_1`` and ``hit_5``: right by the protocol. ``found``: answers that claim to be it, and of
    these ``found_right``. ``unreachable``: no target is among the candidates, so nothing could
    have been right.
    """

    bucket: str
    questions: int
    hit_1: int
    hit_5: int
    found: int
    found_right: int
    not_found: int
    unreachable: int
    fast: int
    reasoned: int
    fallback: int
    ms: float
    vlm_calls: int


@dataclass(frozen=True, slots=True)
class Retrieval:
    """The scores of one kind of candidates under one rule of what counts as a hit.

    ``buckets`` end with all questions whose thing is there (``present``), and with ``all``.
    """

    candidates: str
    hit_rule: str
    reasoning: str
    instances: int
    buckets: tuple[BucketScore, ...]
    answers: tuple[Answered, ...]

    @property
    def wrongly_not_found(self) -> int:
        """How many things that are there were called not found."""
        return sum(one.is_not_found and not one.query.is_absent for one in self.answers)

    def bucket(self, name: str) -> BucketScore | None:
        """Return the scores of one bucket; ``None`` when nothing was asked in it."""
        return next((one for one in self.buckets if one.bucket == name), None)

    def as_dict(self) -> dict[str, Any]:
        """Return everything in values that JSON knows."""
        return {
            "protocol": PROTOCOL,
            "candidates": self.candidates,
            "hit_rule": self.hit_rule,
            "reasoning": self.reasoning,
            "instances": self.instances,
            "wrongly_not_found": self.wrongly_not_found,
            "buckets": [asdict(one) for one in self.buckets],
            "answers": [_answer_dict(one) for one in self.answers],
        }


def evaluate_retrieval(
    candidates: Candidates,
    queries: Sequence[Query],
    setup: Setup,
    reasoning: str = SELECTIVE,
    pictures: Pictures = no_pictures,
) -> tuple[Retrieval, ...]:
    """Ask all ``queries`` once and score the answers by every rule of the candidates.

    ``pictures`` are the frames of the recording, for a reasoner that looks.
    """
    answers = Asking(setup, candidates.snapshot, pictures).ask_all(queries, reasoning)
    return tuple(
        Retrieval(
            candidates=candidates.name,
            hit_rule=rule,
            reasoning=reasoning,
            instances=len(candidates.snapshot),
            buckets=tuple(_scores(answers, matches)),
            answers=answers,
        )
        for rule, matches in candidates.matches.items()
    )


def merged(results: Sequence[Retrieval]) -> Retrieval:
    """Return the results of several scenes as one; they must be of one kind and rule.

    The median time is that of all questions.
    """
    answers = tuple(answer for one in results for answer in one.answers)
    asked = {score.bucket for one in results for score in one.buckets}
    names = [name for name in _in_order(asked) if name in asked]
    first = results[0]
    return Retrieval(
        candidates=first.candidates,
        hit_rule=first.hit_rule,
        reasoning=first.reasoning,
        instances=sum(one.instances for one in results),
        buckets=tuple(_sum(name, results, _chosen(answers, name)) for name in names),
        answers=answers,
    )


def _sum(name: str, results: Sequence[Retrieval], answers: Sequence[Answered]) -> BucketScore:
    scores = [asdict(score) for one in results if (score := one.bucket(name)) is not None]
    counts = {key: sum(score[key] for score in scores) for key in scores[0] if key != "bucket"}
    return BucketScore(**{**counts, "bucket": name, "ms": _median_ms(answers)})


def _scores(answers: Sequence[Answered], matches: Matches) -> Iterable[BucketScore]:
    for name in _in_order({answer.query.bucket for answer in answers}):
        if chosen := _chosen(answers, name):
            yield _score(name, chosen, matches)


def _in_order(asked: Iterable[str]) -> tuple[str, ...]:
    """Return the usual buckets, then any others, then the sums."""
    others = sorted(set(asked) - {*BUCKETS, PRESENT, ALL})
    return (*BUCKETS, *others, PRESENT, ALL)


def _chosen(answers: Sequence[Answered], bucket: str) -> list[Answered]:
    return [answer for answer in answers if _belongs(answer.query, bucket)]


def _belongs(query: Query, bucket: str) -> bool:
    if bucket in (PRESENT, ALL):
        return bucket == ALL or not query.is_absent
    return query.bucket == bucket


def _score(bucket: str, answers: Sequence[Answered], matches: Matches) -> BucketScore:
    right = [_targets(answer.query, matches) for answer in answers]
    pairs = list(zip(answers, right, strict=True))
    return BucketScore(
        bucket=bucket,
        questions=len(answers),
        hit_1=sum(is_right(answer, ids, 1) for answer, ids in pairs),
        hit_5=sum(is_right(answer, ids, 5) for answer, ids in pairs),
        found=sum(answer.is_found for answer in answers),
        found_right=sum(answer.is_found and is_right(answer, ids, 1) for answer, ids in pairs),
        not_found=sum(answer.is_not_found for answer in answers),
        unreachable=sum(not ids and not answer.query.is_absent for answer, ids in pairs),
        fast=sum(answer.route == FAST for answer in answers),
        reasoned=sum(answer.route == REASONED for answer in answers),
        fallback=sum(answer.route == FALLBACK for answer in answers),
        ms=_median_ms(answers),
        vlm_calls=sum(answer.vlm_calls for answer in answers),
    )


def is_right(answer: Answered, targets: frozenset[int], k: int) -> bool:
    """Return whether an answer is right by the protocol; ``targets`` are candidate ids."""
    if answer.query.is_absent:
        return answer.is_not_found
    return hit_at(answer.ranked, targets, k)


def _targets(query: Query, matches: Matches) -> frozenset[int]:
    """Return the candidates that are one of the things the question wants."""
    return frozenset(one for target in query.targets for one in matches.get(target, ()))


def _median_ms(answers: Sequence[Answered]) -> float:
    return float(np.median([answer.ms for answer in answers])) if answers else 0.0


def _answer_dict(answer: Answered) -> dict[str, Any]:
    return {
        "question": answer.query.text,
        "bucket": answer.query.bucket,
        "targets": sorted(answer.query.targets),
        "status": answer.status,
        "route": answer.route,
        "best": list(answer.ranked[:5]),
        "ms": round(answer.ms, 2),
        "vlm_calls": answer.vlm_calls,
        "reason": answer.reason,
    }
