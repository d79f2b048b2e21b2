"""The few instances a reasoner gets to see."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sceneq_core.arrays import Float64, Int64
from sceneq_core.mapping.delta import OBJECT
from sceneq_core.reasoning.reasoner import Candidate, Problem
from sceneq_core.routing.likelihood import Fit
from sceneq_core.routing.question import Question
from sceneq_core.routing.scene import SceneInstance, SceneSnapshot


def pose_problem(
    snapshot: SceneSnapshot, question: Question, fits: Mapping[str, Fit], top_k: int
) -> Problem | None:
    """Return the question with its ``top_k`` best targets, and as many for every anchor.

    ``None`` when nothing in the map can be one of its anchors: then there is nothing to compare.
    """
    phrase = question.phrase
    anchors = tuple(dict.fromkeys(words for c in phrase.constraints for words in c.things))
    if not all(len(fits[words].order) for words in anchors):
        return None
    chosen = [
        _candidates(snapshot, "anchor", words, fits[words], fits[words].order[:top_k])
        for words in anchors
    ]
    rows = _target_rows(snapshot, question, fits)[:top_k]
    target = fits[phrase.target]
    meant = target if phrase.constraints else replace(target, kind=target.p)
    targets = _candidates(snapshot, "target", phrase.target, meant, rows)
    return Problem(
        text=question.text,
        target=phrase.target,
        constraints=phrase.constraints,
        candidates=(*targets, *(c for group in chosen for c in group)),
        up_world=snapshot.up_world,
        viewpoint_world=snapshot.viewpoint_world,
        map_epoch=snapshot.revision.epoch,
    )


def _target_rows(snapshot: SceneSnapshot, question: Question, fits: Mapping[str, Fit]) -> Int64:
    """Best first; when anything will do ("what is on the table?"), closest to the anchor first."""
    phrase = question.phrase
    anchor = next((c.anchor for c in phrase.constraints if c.anchor), "")
    if phrase.target or not anchor:
        return fits[phrase.target].order
    if not len(fits[anchor].order):
        return fits[anchor].order
    nearest_to = int(fits[anchor].order[0])
    around = np.argsort(_gaps(snapshot, nearest_to), kind="stable")
    meant = (around != nearest_to) & (snapshot.columns.role[around] == OBJECT)
    objects: Int64 = around[meant]
    return objects


def _gaps(snapshot: SceneSnapshot, row: int) -> Float64:
    """Return the distances (N,) between the axis-aligned boxes and that of ``row``, metres."""
    boxes = snapshot.columns.aabb_world
    apart = np.maximum(boxes[:, 0] - boxes[row, 1], boxes[row, 0] - boxes[:, 1])
    gaps: Float64 = np.linalg.norm(np.maximum(apart, 0.0), axis=1)
    return gaps


def _candidates(
    snapshot: SceneSnapshot, role: str, words: str, fit: Fit, rows: Int64
) -> list[Candidate]:
    p, cosine = fit.kind, fit.cosine
    return [
        _candidate(snapshot.instances[row], role, words, float(p[row]), float(cosine[row]))
        for row in rows.tolist()
    ]


def _candidate(
    instance: SceneInstance, role: str, words: str, p: float, cosine: float
) -> Candidate:
    return Candidate(
        instance_id=instance.instance_id,
        role=role,
        words=words,
        label=instance.label.name,
        p=p,
        cosine=cosine,
        centre_world=instance.geometry.centre_world,
        T_world_box=instance.geometry.T_world_box,
        box_size_m=instance.geometry.box_size_m,
        views=tuple((view.seq, view.box_xyxy) for view in instance.views),
        supported_by=instance.geometry.supported_by,
        inside=instance.geometry.inside,
        neighbours=tuple(instance.geometry.neighbour_id.tolist()),
    )
