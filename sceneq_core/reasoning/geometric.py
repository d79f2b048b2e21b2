"""The built-in reasoner: what the map's geometry alone can decide."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.checks import need_between
from sceneq_core.reasoning import explanation
from sceneq_core.reasoning.known_relations import with_known
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
from sceneq_core.reasoning.relations import RELATIONS, VIEWER_RELATIVE, Pair, RelationParams
from sceneq_core.reasoning.superlatives import SUPERLATIVES, probability_of_first
from sceneq_core.reasoning.upright import point_box, upright_axes, upright_box


@dataclass(frozen=True, slots=True)
class GeometricParams:
    """``min_score``: product of target, anchor and relation score below which it does not hold."""

    relations: RelationParams = field(default_factory=RelationParams)
    min_score: float = 0.05

    def __post_init__(self) -> None:
        need_between(self, 0, 1, "min_score")


@dataclass(frozen=True, slots=True)
class _Holding:
    """How well ``constraint`` holds for every target: ``score`` (N,), ``anchor`` the best for each.

    There is no anchor when it is the viewer, or when the targets are compared with each other.
    """

    constraint: Constraint
    score: Float64
    anchor: tuple[Candidate | None, ...]


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
        holdings = [self._relate(problem, constraint, targets) for constraint in relational]
        score = _relative([c.p for c in targets])
        for holding in holdings:
            score = score * holding.score
        for constraint in comparing:
            compared = self._compare(problem, constraint, targets, score)
            score = compared.score
            holdings.append(compared)
        return self._verdict(problem, targets, score, holdings)

    def close(self) -> None:
        """Nothing to release."""

    def _verdict(
        self,
        problem: Problem,
        targets: list[Candidate],
        score: Float64,
        holdings: list[_Holding],
    ) -> Verdict:
        """Turn scores into probabilities; ``min_score`` is the weight of "none of them"."""
        keep = [i for i in np.argsort(-score, kind="stable") if score[i] >= self.params.min_score]
        if not keep:
            return Verdict((), explanation.none_holds(problem), 0)
        p = score / (score[keep].sum() + self.params.min_score)
        ranking = tuple((targets[i].instance_id, float(p[i])) for i in keep)
        best = keep[0]
        holding = [(of.constraint, of.anchor[best]) for of in holdings]
        return Verdict(ranking, explanation.why(problem, targets[best], holding), 0)

    def _relate(
        self, problem: Problem, constraint: Constraint, targets: list[Candidate]
    ) -> _Holding:
        """Score a relation with the anchor that explains each target best."""
        if not constraint.anchor and constraint.relation in VIEWER_RELATIVE:
            return _Holding(constraint, np.ones(len(targets)), (None,) * len(targets))
        anchors = _anchors(problem, constraint.anchor)
        weight = _relative([a.p for a in anchors]) if anchors else np.ones(1)
        pairs = np.array([self._row(problem, constraint, t, anchors) for t in targets]) * weight
        best = pairs.argmax(axis=1)
        chosen = tuple(anchors[j] if anchors else None for j in best)
        return _Holding(constraint, pairs[np.arange(len(targets)), best], chosen)

    def _row(
        self,
        problem: Problem,
        constraint: Constraint,
        target: Candidate,
        anchors: list[Candidate],
    ) -> list[float]:
        """Score one target against every anchor; a thing is not next to itself."""
        relation, params = RELATIONS[constraint.relation], self.params.relations
        if not anchors:
            return [relation(_viewer_pair(problem, target), params)]
        return [
            0.0
            if anchor.instance_id == target.instance_id
            else with_known(
                constraint.relation,
                target,
                anchor,
                relation(_pair(problem, target, anchor), params),
            )
            for anchor in anchors
        ]

    def _compare(
        self,
        problem: Problem,
        constraint: Constraint,
        targets: list[Candidate],
        score: Float64,
    ) -> _Holding:
        """Score a superlative: which of the targets comes first, averaged over the anchors."""
        weight = score / score.max() if score.max() > 0 else score
        anchors = _anchors(problem, constraint.anchor)
        reference: Sequence[Candidate | None] = anchors or [None]
        first = [_first(problem, constraint.relation, targets, weight, a) for a in reference]
        parts = np.array(first) * _shares([a.p for a in anchors])[:, None]
        chosen = tuple(reference[j] for j in parts.argmax(axis=0))
        return _Holding(constraint, parts.sum(axis=0), chosen)


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
        if constraint.relation not in RELATIONS and constraint.relation not in SUPERLATIVES:
            raise ValueError(f"relation: unknown {constraint.relation!r}")
    relational = tuple(c for c in constraints if c.relation in RELATIONS)
    return relational, tuple(c for c in constraints if c.relation in SUPERLATIVES)


def _anchors(problem: Problem, words: str) -> list[Candidate]:
    """Return the anchor candidates for ``words``, none for the viewer."""
    found = [c for c in problem.candidates if c.role == "anchor" and c.words == words]
    if words and not found:
        raise ValueError(f"candidates: none for the anchor {words!r}")
    return found if words else []


def _relative(p: list[float]) -> Float64:
    """Return probabilities relative to the largest; all equal when all are zero."""
    values = np.array(p, np.float64)
    return values / values.max() if values.max() > 0 else np.ones(len(p))


def _shares(p: list[float]) -> Float64:
    """Return probabilities that add up to one: one of them is meant; (1,) for no choice."""
    weight = _relative(p) if p else np.ones(1)
    shares: Float64 = weight / weight.sum()
    return shares


def _pair(problem: Problem, target: Candidate, anchor: Candidate) -> Pair:
    axes = upright_axes(anchor.T_world_box, problem.up_world)
    return Pair(
        target=upright_box(target, axes),
        anchor=upright_box(anchor, axes),
        offset_viewer=_viewer_axes(problem, anchor) @ (target.centre_world - anchor.centre_world),
    )


def _viewer_pair(problem: Problem, target: Candidate) -> Pair:
    axes = upright_axes(target.T_world_box, problem.up_world)
    viewer = point_box(problem.viewpoint_world, axes)
    return Pair(target=upright_box(target, axes), anchor=viewer, offset_viewer=np.zeros(3))


def _viewer_axes(problem: Problem, anchor: Candidate) -> Float64:
    """Return rows (3, 3): right, forward and up of somebody who looks at the anchor."""
    up = problem.up_world / np.linalg.norm(problem.up_world)
    forward = anchor.centre_world - problem.viewpoint_world
    forward = forward - (forward @ up) * up
    if np.linalg.norm(forward) < 1e-6:
        forward = upright_axes(anchor.T_world_box, up)[0]
    forward = forward / np.linalg.norm(forward)
    return np.stack([np.cross(forward, up), forward, up])


def _first(
    problem: Problem,
    relation: str,
    targets: list[Candidate],
    weight: Float64,
    anchor: Candidate | None,
) -> Float64:
    """Return the probability of each target (N,) to be first by a superlative.

    Without an anchor it is seen from the viewer; the anchor itself does not take part.
    """
    superlative, measures = SUPERLATIVES[relation], []
    for target in targets:
        axes = upright_axes((anchor or target).T_world_box, problem.up_world)
        viewer = point_box(problem.viewpoint_world, axes)
        other = upright_box(anchor, axes) if anchor else viewer
        measures.append(superlative.measure(upright_box(target, axes), other))
    itself = [anchor is not None and t.instance_id == anchor.instance_id for t in targets]
    real = np.where(itself, 0.0, weight)
    return probability_of_first(real, np.array(measures), superlative.scale)
