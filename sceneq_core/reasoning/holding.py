"""How well one constraint of a question holds for each of its targets."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.reasoning.reasoner import Candidate, Constraint, Problem
from sceneq_core.reasoning.standpoint import Standpoint


@dataclass(frozen=True, slots=True)
class Holding:
    """How well ``constraint`` holds for every target: ``score`` (N,), ``anchor`` the best for each.

    There is no anchor when it is the viewer, or when the targets are compared with each other.
    ``amount`` (N,) is what was measured, in ``unit``; ``None`` where one number does not tell.
    ``standpoint`` is where it was seen from, when that matters.
    """

    constraint: Constraint
    score: Float64
    anchor: tuple[Candidate | None, ...]
    amount: Float64 | None = None
    unit: str = ""
    standpoint: Standpoint | None = None


def anchors_of(problem: Problem, words: str) -> list[Candidate]:
    """Return the anchor candidates for ``words``, none for the viewer.

    Raises:
        ValueError: words without candidates.
    """
    found = [c for c in problem.candidates if c.role == "anchor" and c.words == words]
    if words and not found:
        raise ValueError(f"candidates: none for the anchor {words!r}")
    return found if words else []


def relative(p: Sequence[float]) -> Float64:
    """Return probabilities relative to the largest; all equal when all are zero."""
    values = np.array(p, np.float64)
    return values / values.max() if values.max() > 0 else np.ones(len(p))


def shares(p: Sequence[float]) -> Float64:
    """Return probabilities that add up to one: one of them is meant; (1,) for no choice."""
    weight = relative(p) if p else np.ones(1)
    parts: Float64 = weight / weight.sum()
    return parts
