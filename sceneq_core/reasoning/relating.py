"""Relations of each target to the anchor that explains it best."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.reasoning.holding import Holding, anchors_of, relative
from sceneq_core.reasoning.known_relations import with_known
from sceneq_core.reasoning.reasoner import Candidate, Constraint, Problem
from sceneq_core.reasoning.relations import (
    BY_DISTANCE,
    RELATIONS,
    VIEWER_RELATIVE,
    Pair,
    RelationParams,
    between,
)
from sceneq_core.reasoning.standpoint import Standpoint
from sceneq_core.reasoning.upright import (
    UprightBox,
    distance,
    point_box,
    upright_axes,
    upright_box,
)


def relate(
    problem: Problem, constraint: Constraint, targets: Sequence[Candidate], params: RelationParams
) -> Holding:
    """Return how well a relation holds for every target.

    Raises:
        ValueError: words without candidates.
    """
    if constraint.relation == "between":
        return _lie_between(problem, constraint, targets, params)
    if not constraint.anchor and constraint.relation in VIEWER_RELATIVE:
        return Holding(constraint, np.ones(len(targets)), (None,) * len(targets))
    anchors = anchors_of(problem, constraint.anchor)
    standpoint = Standpoint.of(problem, constraint)
    weight = relative([a.p for a in anchors]) if anchors else np.ones(1)
    frames = [_Frame.of(problem, anchor, standpoint) for anchor in anchors]
    rows = [_row(problem, constraint, one, frames, params) for one in targets]
    pairs = np.array(rows) * weight
    best = pairs.argmax(axis=1)
    chosen = tuple(anchors[j] if anchors else None for j in best)
    score = pairs[np.arange(len(targets)), best]
    measured = constraint.relation in BY_DISTANCE
    return Holding(
        constraint,
        1.0 - score if constraint.negated else score,
        chosen,
        _distances(problem, targets, chosen) if measured else None,
        "m away",
        standpoint if constraint.relation in VIEWER_RELATIVE else None,
    )


@dataclass(frozen=True, slots=True)
class _Frame:
    """An anchor with its upright ``axes`` and those of who looks at it, worked out once."""

    anchor: Candidate
    axes: Float64
    box: UprightBox
    seen: Float64

    @classmethod
    def of(cls, problem: Problem, anchor: Candidate, standpoint: Standpoint) -> "_Frame":
        axes = upright_axes(anchor.T_world_box, problem.up_world)
        seen = standpoint.axes(anchor, problem.up_world)
        return cls(anchor, axes, upright_box(anchor, axes), seen)

    def pair(self, target: Candidate) -> Pair:
        offset = self.seen @ (target.centre_world - self.anchor.centre_world)
        return Pair(upright_box(target, self.axes), self.box, offset)


def _row(
    problem: Problem,
    constraint: Constraint,
    target: Candidate,
    frames: Sequence[_Frame],
    params: RelationParams,
) -> list[float]:
    """Score one target against every anchor; a thing is not next to itself."""
    relation = RELATIONS[constraint.relation]
    if not frames:
        return [relation(_viewer_pair(problem, target), params)]
    return [
        0.0
        if frame.anchor.instance_id == target.instance_id
        else with_known(
            constraint.relation, target, frame.anchor, relation(frame.pair(target), params)
        )
        for frame in frames
    ]


def _viewer_pair(problem: Problem, target: Candidate) -> Pair:
    axes = upright_axes(target.T_world_box, problem.up_world)
    viewer = point_box(problem.viewpoint_world, axes)
    return Pair(target=upright_box(target, axes), anchor=viewer, offset_viewer=np.zeros(3))


def _distances(
    problem: Problem, targets: Sequence[Candidate], anchors: Sequence[Candidate | None]
) -> Float64:
    """Return the shortest distances (N,) between targets and anchors, or the viewer, metres."""
    gaps = []
    for target, anchor in zip(targets, anchors, strict=True):
        axes = upright_axes((anchor or target).T_world_box, problem.up_world)
        viewer = point_box(problem.viewpoint_world, axes)
        other = upright_box(anchor, axes) if anchor else viewer
        gaps.append(distance(upright_box(target, axes), other))
    return np.array(gaps)


def _lie_between(
    problem: Problem, constraint: Constraint, targets: Sequence[Candidate], params: RelationParams
) -> Holding:
    """Score every target by the two anchors that it lies between best."""
    ones = anchors_of(problem, constraint.anchor)
    others = anchors_of(problem, constraint.other)
    weight = np.outer(relative([a.p for a in ones]), relative([b.p for b in others]))
    score, chosen = np.zeros(len(targets)), []
    for i, target in enumerate(targets):
        pairs = weight * [[_in_gap(problem, target, a, b, params) for b in others] for a in ones]
        score[i] = pairs.max()
        chosen.append(ones[int(pairs.max(axis=1).argmax())])
    return Holding(constraint, 1.0 - score if constraint.negated else score, tuple(chosen))


def _in_gap(
    problem: Problem, target: Candidate, one: Candidate, other: Candidate, params: RelationParams
) -> float:
    if len({target.instance_id, one.instance_id, other.instance_id}) < 3:
        return 0.0
    axes = upright_axes(one.T_world_box, problem.up_world)
    middle, start, end = (upright_box(part, axes) for part in (target, one, other))
    return between(middle, start, end, params.reach_m)
