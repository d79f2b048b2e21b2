"""The seam between the router and whatever thinks longer about a few candidates."""

from dataclasses import dataclass
from typing import Protocol

from sceneq_core.arrays import Float64


@dataclass(frozen=True, slots=True)
class Candidate:
    """An instance as a reasoner sees it; metres, world frame.

    ``role`` is ``target`` or ``anchor`` (the thing a spatial relation refers to); ``p`` is the
    encoder's probability that it is what its role's words say; ``views`` are keyframe seqs with
    boxes (xyxy pixels), most visible first.
    """

    instance_id: int
    role: str
    label: str
    p: float
    cosine: float
    centre_world: Float64
    aabb_world: Float64
    views: tuple[tuple[int, tuple[float, float, float, float]], ...]


@dataclass(frozen=True, slots=True)
class Problem:
    """A question with its candidates; ``up_world`` is against gravity.

    ``viewpoint_world`` is where "left" and "right" are seen from: the newest camera position.
    """

    text: str
    candidates: tuple[Candidate, ...]
    up_world: Float64
    viewpoint_world: Float64


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a reasoner found: target ids best first with their probabilities, and why.

    An empty ``ranking`` = none of the candidates.
    """

    ranking: tuple[tuple[int, float], ...]
    reason: str
    vlm_calls: int


class Reasoner(Protocol):
    """Chooses among candidates."""

    def solve(self, problem: Problem) -> Verdict:
        """Return the verdict; raise ``ValueError`` naming what in the problem is unusable."""
