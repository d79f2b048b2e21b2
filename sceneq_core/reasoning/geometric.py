"""The built-in reasoner: what the map's geometry alone can decide."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.checks import need_between
from sceneq_core.reasoning import explanation
from sceneq_core.reasoning.comparing import compare
from sceneq_core.reasoning.holding import Holding, relative
from sceneq_core.reasoning.reasoner import (
    Candidate,
    Constraint,
    LabelProblem,
    LabelVerdict,
    Pictures,
    Problem,
    Verdict,
    no_pictures,
)
from sceneq_core.reasoning.relating import relate
from sceneq_core.reasoning.relations import RELATIONS, RelationParams
from sceneq_core.reasoning.superlatives import SIDEWAYS, SUPERLATIVES

COMPARED = frozenset({*SUPERLATIVES, *SIDEWAYS})
KNOWN = COMPARED | {*RELATIONS, "between"}


@dataclass(frozen=True, slots=True)
class GeometricParams:
    """``min_score``: product of target, anchor and relation score below which it does not hold."""

    relations: RelationParams = field(default_factory=RelationParams)
    min_score: float = 0.05

    def __post_init__(self) -> None:
        need_between(self, 0, 1, "min_score")


class GeometricReasoner:
    """Ranks targets by P(target) x P(anchor) x how well the relation holds.

    The probabilities count relative to the best candidate of their words: the question presumes
    that there is such a thing, the geometry says which.
    """

    Params: ClassVar[type] = GeometricParams

    def __init__(self, params: GeometricParams) -> None:
        self.params = params

    def label(self, problem: LabelProblem, pictures: Pictures = no_pictures) -> LabelVerdict:
        """Return the encoder's labels as they are: geometry knows no names."""
        total = sum(p for _, p in problem.labels) or 1.0
        ranking = tuple((name, p / total) for name, p in problem.labels)
        return LabelVerdict(ranking, explanation.no_names(), 0)

    def solve(self, problem: Problem, pictures: Pictures = no_pictures) -> Verdict:
        """Return the targets that satisfy all constraints.

        Raises:
            ValueError: an unknown relation, or a constraint on words without candidates.
        """
        targets = [c for c in problem.candidates if c.role == "target"]
        if not targets:
            return Verdict((), explanation.no_candidates(problem), 0)
        if not problem.constraints:
            return _undecided(targets)
        relational, comparing = _sorted_out(problem.constraints)
        holdings = [relate(problem, one, targets, self.params.relations) for one in relational]
        score = relative([c.p for c in targets])
        for holding in holdings:
            score = score * holding.score
        for constraint in comparing:
            compared = compare(problem, constraint, targets, score)
            score = compared.score
            holdings.append(compared)
        return self._verdict(problem, targets, score, holdings)

    def holds(self, problem: Problem) -> dict[int, float]:
        """Return how well all relations hold for each target by its id, in [0, 1].

        Whether it is such a thing at all does not count, nor do superlatives; raises as ``solve``.
        """
        targets = [c for c in problem.candidates if c.role == "target"]
        relational, _ = _sorted_out(problem.constraints)
        score = np.ones(len(targets))
        for constraint in relational:
            score = score * relate(problem, constraint, targets, self.params.relations).score
        return {one.instance_id: float(p) for one, p in zip(targets, score, strict=True)}

    def close(self) -> None:
        """Nothing to release."""

    def _verdict(
        self,
        problem: Problem,
        targets: list[Candidate],
        score: Float64,
        holdings: list[Holding],
    ) -> Verdict:
        """Turn scores into probabilities; ``min_score`` is the weight of "none of them"."""
        keep = [i for i in np.argsort(-score, kind="stable") if score[i] >= self.params.min_score]
        if not keep:
            return Verdict((), explanation.none_holds(problem), 0)
        p = score / (score[keep].sum() + self.params.min_score)
        ranking = tuple((targets[i].instance_id, float(p[i])) for i in keep)
        return Verdict(ranking, explanation.why(problem, targets, score, holdings), 0)


def _undecided(targets: list[Candidate]) -> Verdict:
    """Without a relation or a size there is nothing to add to what the encoder said."""
    ranked = sorted(targets, key=lambda target: -target.p)
    ranking = tuple((target.instance_id, target.p) for target in ranked)
    return Verdict(ranking, explanation.nothing_to_decide_by(), 0)


def _sorted_out(
    constraints: tuple[Constraint, ...],
) -> tuple[tuple[Constraint, ...], tuple[Constraint, ...]]:
    """Separate relations from superlatives, which choose among what the relations leave."""
    for constraint in constraints:
        if constraint.relation not in KNOWN:
            raise ValueError(f"relation: unknown {constraint.relation!r}")
    relational = tuple(c for c in constraints if c.relation not in COMPARED)
    return relational, tuple(c for c in constraints if c.relation in COMPARED)
