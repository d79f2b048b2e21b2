"""Superlatives and ordinals: targets compared with each other."""

from collections.abc import Sequence

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.reasoning.holding import Holding, anchors_of, shares
from sceneq_core.reasoning.reasoner import Candidate, Constraint, Problem
from sceneq_core.reasoning.standpoint import Standpoint
from sceneq_core.reasoning.superlatives import (
    SIDEWAYS,
    SIDEWAYS_SCALE_M,
    SUPERLATIVES,
    probability_of_rank,
)
from sceneq_core.reasoning.upright import point_box, upright_axes, upright_box


def compare(
    problem: Problem, constraint: Constraint, targets: Sequence[Candidate], score: Float64
) -> Holding:
    """Return which target comes first, or ``rank``-th, averaged over the anchors.

    ``score`` (N,): how well each of them is one of those that are compared.
    """
    weight = score / score.max() if score.max() > 0 else score
    if constraint.relation in SIDEWAYS:
        return _sideways(problem, constraint, targets, weight)
    anchors = anchors_of(problem, constraint.anchor)
    reference: Sequence[Candidate | None] = anchors or [None]
    superlative = SUPERLATIVES[constraint.relation]
    measures = np.array([_measure(problem, constraint, targets, a) for a in reference])
    first = [
        probability_of_rank(
            _without(weight, targets, a), measure, superlative.scale, constraint.rank
        )
        for a, measure in zip(reference, measures, strict=True)
    ]
    parts = np.array(first) * shares([a.p for a in anchors])[:, None]
    best = parts.argmax(axis=0)
    amount = superlative.amount(measures[best, np.arange(len(targets))])
    return Holding(
        constraint,
        parts.sum(axis=0),
        tuple(reference[j] for j in best),
        amount if superlative.unit else None,
        superlative.unit,
    )


def _sideways(
    problem: Problem, constraint: Constraint, targets: Sequence[Candidate], weight: Float64
) -> Holding:
    """Order the targets from left to right, as somebody sees them who looks at their middle."""
    standpoint = Standpoint.of(problem, constraint)
    points = np.array([target.centre_world for target in targets])
    right = standpoint.axes_over(points, weight, problem.up_world)[0]
    measure = SIDEWAYS[constraint.relation] * (points @ right)
    score = probability_of_rank(weight, measure, SIDEWAYS_SCALE_M, constraint.rank)
    return Holding(constraint, score, (None,) * len(targets), standpoint=standpoint)


def _measure(
    problem: Problem,
    constraint: Constraint,
    targets: Sequence[Candidate],
    anchor: Candidate | None,
) -> list[float]:
    """Return what the superlative makes small; without an anchor it is seen from the viewer."""
    measures = []
    for target in targets:
        axes = upright_axes((anchor or target).T_world_box, problem.up_world)
        viewer = point_box(problem.viewpoint_world, axes)
        other = upright_box(anchor, axes) if anchor else viewer
        superlative = SUPERLATIVES[constraint.relation]
        measures.append(superlative.measure(upright_box(target, axes), other))
    return measures


def _without(weight: Float64, targets: Sequence[Candidate], anchor: Candidate | None) -> Float64:
    """The anchor itself does not take part."""
    itself = [anchor is not None and t.instance_id == anchor.instance_id for t in targets]
    return np.where(itself, 0.0, weight)
