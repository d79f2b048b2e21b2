"""The seam between the router and whatever thinks longer about a few candidates."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from sceneq_core.arrays import Float64, UInt8

Box = tuple[float, float, float, float]
Views = tuple[tuple[int, Box], ...]

Pictures = Callable[[int, float], UInt8 | None]
"""The keyframe with a seq, uint8 (H, W, 3) RGB, or ``None``; waits at most so many seconds."""


def no_pictures(seq: int, timeout_s: float) -> UInt8 | None:
    """Return ``None``: for reasoners that look at nothing."""
    return None


@dataclass(frozen=True, slots=True)
class Candidate:
    """An instance as a reasoner sees it; metres, world frame.

    ``role`` is ``target`` or ``anchor`` (the thing a spatial relation refers to); ``words`` is the
    part of the question it is a candidate for, and ``p`` the encoder's probability, over all
    instances, that it is the one they mean. One instance may be a candidate for several words.
    ``supported_by``, ``inside`` and ``neighbours`` are instance ids as the map knows them, 0 and
    () = not known. ``T_world_box`` (4, 4) holds centre and axes of the oriented box,
    ``box_size_m`` (3,) its edges; ``views`` are keyframe seqs with boxes (xyxy pixels), most
    visible first.
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
    views: Views
    supported_by: int = 0
    inside: int = 0
    neighbours: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Constraint:
    """The target is ``relation`` of ``anchor``, the ``words`` of anchor candidates.

    An empty anchor is the viewer for relations such as ``nearest`` and nothing for sizes such
    as ``largest``, which compare the targets with each other. ``other`` is the second anchor of
    ``between``; ``rank`` 2 is the second nearest or largest. Left and right are as ``seen_from``
    the thing of these words, or by the viewer ``facing`` it. ``negated``: it is not so.
    """

    relation: str
    anchor: str
    other: str = ""
    rank: int = 1
    seen_from: str = ""
    facing: str = ""
    negated: bool = False

    @property
    def things(self) -> tuple[str, ...]:
        """The words for all things it refers to."""
        named = (self.anchor, self.other, self.seen_from, self.facing)
        return tuple(dict.fromkeys(words for words in named if words))


@dataclass(frozen=True, slots=True)
class Problem:
    """A question with its candidates.

    ``text`` is what was asked, ``target`` the words for the thing wanted ("" = anything); all
    ``constraints`` must hold. ``up_world`` (3,) is against gravity; ``viewpoint_world`` (3,) is
    where "left" and "right" are seen from: the newest camera position. ``time_s``: how long the
    asker waits for the verdict. ``may_spend``: whether it may cost a call of a model; else only a
    reasoner that costs nothing answers. ``map_epoch`` is that of the ids.
    """

    text: str
    target: str
    constraints: tuple[Constraint, ...]
    candidates: tuple[Candidate, ...]
    up_world: Float64
    viewpoint_world: Float64
    time_s: float = math.inf
    may_spend: bool = True
    map_epoch: int = 0


@dataclass(frozen=True, slots=True)
class LabelProblem:
    """What is this thing called? ``labels`` are the encoder's best with p, best first.

    ``views`` are those of ``Candidate``; ``time_s``, ``may_spend`` and ``map_epoch`` those of
    ``Problem``.
    """

    instance_id: int
    labels: tuple[tuple[str, float], ...]
    views: Views
    time_s: float = math.inf
    may_spend: bool = True
    map_epoch: int = 0


@dataclass(frozen=True, slots=True)
class Usage:
    """What a model was paid: tokens read and written, and money in the currency of the prices."""

    tokens_in: int = 0
    tokens_out: int = 0
    money: float = 0.0

    def __add__(self, other: "Usage") -> "Usage":
        return Usage(
            self.tokens_in + other.tokens_in,
            self.tokens_out + other.tokens_out,
            self.money + other.money,
        )


NO_USAGE = Usage()


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a reasoner found: target ids best first with their probabilities, and why.

    The probabilities add up to at most 1; what is missing is "none of them". An empty
    ``ranking`` = none of the candidates. ``cached``: found for somebody else, who paid the
    ``vlm_calls`` and ``usage``; ``billed`` is what remains to be paid.
    """

    ranking: tuple[tuple[int, float], ...]
    reason: str
    vlm_calls: int
    usage: Usage = NO_USAGE
    cached: bool = False

    @property
    def billed(self) -> tuple[int, Usage]:
        """Calls and usage that whoever is told this pays for."""
        return (0, NO_USAGE) if self.cached else (self.vlm_calls, self.usage)


@dataclass(frozen=True, slots=True)
class LabelVerdict:
    """What a thing is called: labels best first with probabilities that add up to 1, and why."""

    ranking: tuple[tuple[str, float], ...]
    reason: str
    vlm_calls: int
    usage: Usage = NO_USAGE
    cached: bool = False

    @property
    def billed(self) -> tuple[int, Usage]:
        """Calls and usage that whoever is told this pays for."""
        return (0, NO_USAGE) if self.cached else (self.vlm_calls, self.usage)


class UnansweredError(Exception):
    """The reasoner cannot tell now: it is down, late, out of budget or not to be understood.

    The text says why. What was spent on the attempt is spent all the same.
    """

    def __init__(self, why: str, vlm_calls: int = 0, usage: Usage = NO_USAGE) -> None:
        super().__init__(why)
        self.vlm_calls = vlm_calls
        self.usage = usage


class Reasoner(Protocol):
    """Chooses among candidates."""

    def solve(self, problem: Problem, pictures: Pictures = no_pictures) -> Verdict:
        """Return the instance that is meant, within the problem's time.

        Raises:
            ValueError: naming what in the problem is unusable.
            UnansweredError: no verdict now.
        """

    def label(self, problem: LabelProblem, pictures: Pictures = no_pictures) -> LabelVerdict:
        """Return what an instance is called; raises as ``solve``."""

    def close(self) -> None:
        """Release connections and memory; nothing is asked afterwards."""
