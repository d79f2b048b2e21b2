"""What answers claim at once, and how often that is wrong: the encoder alone, no reasoner."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from sceneq_core.evaluation.ranking import auroc, hit_at
from sceneq_core.routing.answer import FOUND, NOT_FOUND, Answer
from sceneq_core.routing.router import Router
from sceneq_tools.evaluation.calibration_guesses import Guess, right_candidates
from sceneq_tools.evaluation.retrieval_candidates import Candidates
from sceneq_tools.evaluation.retrieval_queries import Query

CLAIMS = (
    "claims: answers of the encoder alone that say found or not_found, right when the first match "
    "is a target, or nothing is; AUROC of absence: by 1 - presence"
)


@dataclass(frozen=True, slots=True)
class Claim:
    """The encoder's answer: its ``status``, whether it was ``enough``, and whether it is right."""

    status: str
    enough: bool
    is_right: bool


@dataclass(frozen=True, slots=True)
class Claims:
    """How many ``questions`` were claimed to be ``found`` or ``not_found``, and rightly so.

    ``absent`` questions have no right instance, ``absence_auroc`` says how well they are told from
    the others, ``None`` without either.
    """

    questions: int
    found: int
    found_right: int
    not_found: int
    not_found_right: int
    absent: int
    absence_auroc: float | None

    @property
    def risk(self) -> float:
        """The share of ``found`` that is wrong; 0 without any."""
        return 1.0 - self.found_right / self.found if self.found else 0.0

    def as_dict(self) -> dict[str, Any]:
        """Return everything in values that JSON knows."""
        return {**asdict(self), "risk": self.risk}


def first_claim(router: Router, candidates: Candidates, query: Query) -> Claim:
    """Return what the router answers without a reasoner."""
    routed = router.answer(candidates.snapshot, router.read(query.text))
    status, enough = routed.answer.status, routed.enough
    if query.is_absent or status == NOT_FOUND:
        return Claim(status, enough, query.is_absent and status == NOT_FOUND)
    return Claim(status, enough, _is_hit(routed.answer, candidates, query))


def claims_of(made: Sequence[Claim], asked: Sequence[Guess]) -> Claims:
    """Return the sums of ``made``; ``asked`` are the guesses of the questions that have one."""
    found = [one.is_right for one in made if one.status == FOUND]
    not_found = [one.is_right for one in made if one.status == NOT_FOUND]
    absent = np.array([not one.has_answer for one in asked], np.bool_)
    return Claims(
        questions=len(made),
        found=len(found),
        found_right=sum(found),
        not_found=len(not_found),
        not_found_right=sum(not_found),
        absent=int(absent.sum()),
        absence_auroc=auroc(np.array([one.absence for one in asked], np.float64), absent),
    )


def _is_hit(answer: Answer, candidates: Candidates, query: Query) -> bool:
    best = [match.instance.instance_id for match in answer.matches[:1]]
    return hit_at(best, right_candidates(candidates, query), 1)
