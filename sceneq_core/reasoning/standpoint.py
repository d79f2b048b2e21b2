"""Where left, right, in front and behind are seen from."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.reasoning.reasoner import Candidate, Constraint, Problem
from sceneq_core.reasoning.upright import upright_axes


@dataclass(frozen=True, slots=True)
class Standpoint:
    """A place (3,) in the world and, if it is known, the point (3,) that is looked at, metres.

    ``thing`` is the instance that gave one of them, ``None`` = the viewer.
    """

    place_world: Float64
    facing_world: Float64 | None
    thing: Candidate | None

    @classmethod
    def of(cls, problem: Problem, constraint: Constraint) -> "Standpoint":
        """Return the standpoint that a constraint names, else the viewer's."""
        if constraint.seen_from:
            thing = _likeliest(problem, constraint.seen_from)
            return cls(thing.centre_world, None, thing)
        if constraint.facing:
            thing = _likeliest(problem, constraint.facing)
            return cls(problem.viewpoint_world, thing.centre_world, thing)
        return cls(problem.viewpoint_world, None, None)

    def axes(self, towards: Candidate, up_world: Float64) -> Float64:
        """Return rows (3, 3), right, forward and up, of somebody who looks at ``towards``.

        Right above or below it there is no such direction: then it is along its box.
        """
        up = up_world / np.linalg.norm(up_world)
        return self._axes(towards.centre_world, up, upright_axes(towards.T_world_box, up)[0])

    def axes_over(self, points_world: Float64, weight: Float64, up_world: Float64) -> Float64:
        """Return the axes of somebody who looks at the middle of points (N, 3), weighted (N,)."""
        up = up_world / np.linalg.norm(up_world)
        middle = (points_world * weight[:, None]).sum(axis=0) / max(weight.sum(), 1e-9)
        return self._axes(middle, up, np.roll(up, 1))

    def _axes(self, towards_world: Float64, up: Float64, otherwise: Float64) -> Float64:
        target = towards_world if self.facing_world is None else self.facing_world
        forward = target - self.place_world
        forward = forward - (forward @ up) * up
        if np.linalg.norm(forward) < 1e-6:
            forward = otherwise - (otherwise @ up) * up
        forward = forward / np.linalg.norm(forward)
        return np.stack([np.cross(forward, up), forward, up])


def _likeliest(problem: Problem, words: str) -> Candidate:
    found = [c for c in problem.candidates if c.role == "anchor" and c.words == words]
    if not found:
        raise ValueError(f"candidates: none for the anchor {words!r}")
    return max(found, key=lambda candidate: candidate.p)
