"""Verdicts that still hold: the same question about things that have not changed.

A verdict holds as long as the question would be put to the reasoner in the same words about the
same candidates. That is: in the same map epoch, the same instances are candidates for the same
words, no rival has come among them and none has left; none has moved or grown by more than
``moved_m``, is called otherwise, or rests on or in something else; and none has become more or less
likely beside the best candidate by more than ``likely``. What changes elsewhere in the map does not
matter: nothing there could be chosen. Everything is compared with the state that the verdict was
made in, so slow drift adds up and ends it, too. A verdict that cost nothing holds only as long as
nothing of this changes at all: a new one is better and as cheap.
"""

from collections import OrderedDict
from dataclasses import dataclass, fields, replace
from typing import Generic, TypeVar

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.checks import need_at_least, need_within
from sceneq_core.reasoning.reasoner import (
    NO_USAGE,
    Candidate,
    LabelProblem,
    LabelVerdict,
    Problem,
    Verdict,
)
from sceneq_core.reasoning.relations import VIEWER_RELATIVE
from sceneq_core.reasoning.superlatives import COMPARED_TO_ANCHOR, SIDEWAYS, SUPERLATIVES

V = TypeVar("V", bound=Verdict | LabelVerdict)

SIZES = tuple(name for name in SUPERLATIVES if name not in COMPARED_TO_ANCHOR)
COMPARED_BY_TOLERANCE = ("text", "candidates", "labels", "views", "up_world", "viewpoint_world")
NOT_COMPARED = ("time_s", "may_spend")
"""How long the asker waits and what it may cost do not change what is right."""


@dataclass(frozen=True, slots=True)
class RememberedParams:
    """``capacity``: questions remembered, 0 = none.

    ``moved_m``: how far a box's corner may move, a few centimetres being the noise of half-seen
    things. ``likely``: how far p relative to the best candidate's may change. ``viewpoint_m``: how
    far the camera may move when the question speaks of left, right or nearest to the viewer.
    ``tilt``: how far the unit vector up may move; 0.05 is three degrees.
    """

    capacity: int = 256
    moved_m: float = 0.05
    likely: float = 0.1
    viewpoint_m: float = 0.25
    tilt: float = 0.05

    def __post_init__(self) -> None:
        need_within(self, 0, 100_000, "capacity")
        need_within(self, 0, 1, "likely")
        need_at_least(self, 0, "moved_m", "viewpoint_m", "tilt")


EXACT = RememberedParams(moved_m=0.0, likely=0.0, viewpoint_m=0.0, tilt=0.0)


class Remembered(Generic[V]):
    """The last verdicts, each with the problem it solved."""

    def __init__(self, params: RememberedParams) -> None:
        self._params = params
        self._known: OrderedDict[str, tuple[Problem | LabelProblem, V]] = OrderedDict()

    def keep(self, problem: Problem | LabelProblem, verdict: V) -> None:
        """Remember the verdict on a problem."""
        key = question_of(problem)
        self._known[key] = problem, verdict
        self._known.move_to_end(key)
        while len(self._known) > self._params.capacity:
            self._known.popitem(last=False)

    def recall(self, problem: Problem | LabelProblem) -> V | None:
        """Return the verdict, cached, if it still holds; one that does not is forgotten."""
        key = question_of(problem)
        if key not in self._known:
            return None
        then, verdict = self._known[key]
        paid = verdict.vlm_calls > 0 or verdict.usage != NO_USAGE
        if not still_holds(then, problem, self._params if paid else EXACT):
            del self._known[key]
            return None
        self._known.move_to_end(key)
        return replace(verdict, cached=True)


def question_of(problem: Problem | LabelProblem) -> str:
    """Return what is asked, without case and spacing."""
    if isinstance(problem, LabelProblem):
        return f"label {problem.instance_id}"
    return "ask " + " ".join(problem.text.lower().split())


def still_holds(
    then: Problem | LabelProblem, now: Problem | LabelProblem, params: RememberedParams
) -> bool:
    """Return whether what was right ``then`` is right ``now``."""
    if type(then) is not type(now) or question_of(then) != question_of(now):
        return False
    exact = (f.name for f in fields(then) if f.name not in COMPARED_BY_TOLERANCE + NOT_COMPARED)
    if any(getattr(then, name) != getattr(now, name) for name in exact):
        return False
    if isinstance(then, Problem) and isinstance(now, Problem):
        return _same_view(then, now, params) and _same_candidates(then, now, params)
    assert isinstance(then, LabelProblem)
    assert isinstance(now, LabelProblem)
    return _same_labels(then, now, params)


def needs_viewpoint(problem: Problem) -> bool:
    """Return whether the answer depends on where the camera is."""
    return any(
        c.relation in (*VIEWER_RELATIVE, *SIDEWAYS)
        or (not c.anchor and c.relation not in SIZES)  # without an anchor the viewer is it
        for c in problem.constraints
    )


def _same_view(then: Problem, now: Problem, params: RememberedParams) -> bool:
    if _apart(then.up_world, now.up_world) > params.tilt:
        return False
    moved_m = _apart(then.viewpoint_world, now.viewpoint_world)
    return moved_m <= params.viewpoint_m or not needs_viewpoint(then)


def _same_candidates(then: Problem, now: Problem, params: RememberedParams) -> bool:
    before = {(c.role, c.words, c.instance_id): c for c in then.candidates}
    after = {(c.role, c.words, c.instance_id): c for c in now.candidates}
    if before.keys() != after.keys():
        return False
    likely_before, likely_after = _relative_p(then), _relative_p(now)
    return all(
        _same_thing(one, after[key], params.moved_m)
        and abs(likely_before[key] - likely_after[key]) <= params.likely
        for key, one in before.items()
    )


def _same_thing(then: Candidate, now: Candidate, moved_m: float) -> bool:
    known_then = then.label, then.supported_by, then.inside
    known_now = now.label, now.supported_by, now.inside
    return known_then == known_now and _apart(_corners(then), _corners(now)) <= moved_m


def _corners(candidate: Candidate) -> Float64:
    """Return the extent (2, 3) of the oriented box along the world's axes: no box flips by it."""
    half = np.abs(candidate.T_world_box[:3, :3]) @ (candidate.box_size_m / 2)
    centre = candidate.T_world_box[:3, 3]
    return np.stack([centre - half, centre + half])


def _relative_p(problem: Problem) -> dict[tuple[str, str, int], float]:
    """Return p beside the best candidate's for the same words: other instances cancel out."""
    best: dict[tuple[str, str], float] = {}
    for c in problem.candidates:
        best[c.role, c.words] = max(best.get((c.role, c.words), 0.0), c.p)
    return {
        (c.role, c.words, c.instance_id): c.p / (best[c.role, c.words] or 1.0)
        for c in problem.candidates
    }


def _same_labels(then: LabelProblem, now: LabelProblem, params: RememberedParams) -> bool:
    """A name depends on how the thing looks: other views may show it to be something else."""
    if [name for name, _ in then.labels] != [name for name, _ in now.labels]:
        return False
    changed = max(
        (abs(a - b) for (_, a), (_, b) in zip(then.labels, now.labels, strict=True)), default=0.0
    )
    seen_then, seen_now = ([seq for seq, _ in one.views] for one in (then, now))
    return changed <= params.likely and seen_then == seen_now


def _apart(one: Float64, other: Float64) -> float:
    """Return the largest distance between rows of two arrays (..., 3)."""
    return float(np.linalg.norm(one - other, axis=-1).max(initial=0.0))
