"""The seam between the router and whatever thinks longer about a few candidates."""

from dataclasses import dataclass
from typing import Protocol

from sceneq_core.arrays import Float64

Box = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Candidate:
    """An instance as a reasoner sees it; metres, world frame.

    ``role`` is ``target`` or ``anchor`` (the thing a spatial relation refers to); ``words`` is the
    part of the question it is a candidate for, and ``p`` the encoder's probability, over all
    instances, that it is the one they mean. One instance may be a candidate for several words.
    ``T_world_box`` (4, 4) holds centre and axes of the oriented box, ``box_size_m`` (3,) its
    edges; ``views`` are keyframe seqs with boxes (xyxy pixels), most visible first.
    """

    instance_id: int
    role: str
    words: str
    label: str
    p: float
    cosine: float
    centre_world: Float64
    T_world_box: Float64
    box_size_m: Float64
    views: tuple[tuple[int, Box], ...]


@dataclass(frozen=True, slots=True)
class Constraint:
    """The target is ``relation`` of ``anchor``, the ``words`` of anchor candidates.

    An empty anchor is the viewer for relations such as ``nearest`` and nothing for sizes such
    as ``largest``, which compare the targets with each other.
    """

    relation: str
    anchor: str


@dataclass(frozen=True, slots=True)
class Problem:
    """A question with its candidates.

    ``text`` is what was asked, ``target`` the words for the thing wanted ("" = anything); all
    ``constraints`` must hold. ``up_world`` (3,) is against gravity; ``viewpoint_world`` (3,) is
    where "left" and "right" are seen from: the newest camera position.
    """

    text: str
    target: str
    constraints: tuple[Constraint, ...]
    candidates: tuple[Candidate, ...]
    up_world: Float64
    viewpoint_world: Float64


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a reasoner found: target ids best first with their probabilities, and why.

    The probabilities add up to at most 1; what is missing is "none of them". An empty
    ``ranking`` = none of the candidates.
    """

    ranking: tuple[tuple[int, float], ...]
    reason: str
    vlm_calls: int


class Reasoner(Protocol):
    """Chooses among candidates."""

    def solve(self, problem: Problem) -> Verdict:
        """Return the verdict; raise ``ValueError`` naming what in the problem is unusable."""
