"""What a reasoner may be expected to change, and to cost."""

import math
from collections import deque
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

from sceneq_core.checks import need_at_least, need_positive, need_within
from sceneq_core.routing.budget import Budget, Cost

THING, RELATION, ABSENCE, NAME = "thing", "relation", "absence", "name"
KINDS = (THING, RELATION, ABSENCE)
"""Questions about a thing alone, with a relation or a size, and those of either kind that the
encoder answers with "not found": a reasoner is of very different use to them."""

FARTHEST = 1e-6
"""Probabilities are kept so far from 0 and 1: nothing is that sure."""

ONE_CALL = Cost(calls=1, tokens=2000)
"""What a question is taken to cost before one was paid: four pictures of 640x480 are about 1600
tokens to Qwen2.5-VL."""


@dataclass(frozen=True, slots=True)
class Skill:
    """``mends``: share of the encoder's wrong answers that the reasoner puts right; ``keeps``:
    share of its right answers that it leaves right.

    ``scale`` and ``bias`` correct the probability p that the encoder is right, for this kind of
    question: sigmoid(scale x logit(p) + bias). All four are an opinion, not a measurement;
    ``sceneq eval ablation --policies`` measures them and prints the line for the graph.
    """

    mends: float = 0.5
    keeps: float = 0.9
    scale: float = 1.0
    bias: float = 0.0

    def __post_init__(self) -> None:
        need_within(self, 0, 1, "mends", "keeps")
        need_within(self, 0, 10, "scale")
        need_within(self, -10, 10, "bias")

    def gain(self, p_right: float) -> float:
        """Return how much more probably right an answer becomes that says it is so by p."""
        p = self.corrected(p_right)
        return (1.0 - p) * self.mends - p * (1.0 - self.keeps)

    def corrected(self, p_right: float) -> float:
        """Return the probability that an answer is right that says so by ``p_right``."""
        return 1.0 / (1.0 + math.exp(-self.scale * log_odds(p_right) - self.bias))


def log_odds(p: float) -> float:
    """Return log(p / (1 - p)), finite."""
    safe = min(max(p, FARTHEST), 1.0 - FARTHEST)
    return math.log(safe / (1.0 - safe))


@dataclass(frozen=True, slots=True)
class OutlookParams:
    """What is expected at first: a skill for each of ``KINDS``.

    The encoder's p says little of a relation, "not found" is right more often than it says, and
    what it does not find is seldom among the candidates that a reasoner is shown: so it is with
    the embedded encoder in the rooms that it is calibrated on, hence the defaults.

    ``weight``: how many questions that is worth beside what is learned; ``memory``: of how many of
    the last questions of a kind the cost is averaged.
    """

    thing: Skill = field(default_factory=Skill)
    relation: Skill = field(default_factory=lambda: Skill(scale=0.3))
    absence: Skill = field(default_factory=lambda: Skill(mends=0.3, bias=1.0))
    weight: float = 10.0
    memory: int = 20

    def __post_init__(self) -> None:
        need_positive(self, "weight")
        need_at_least(self, 1, "memory")


class Outlook:
    """Learns from every verdict what it cost and whether it changed the answer.

    Whether it was right is seldom told; where it is, ``judged`` learns that, too. Without it the
    skill stays what the parameters say, but nobody gains more than he changes: a reasoner that
    agrees with the encoder all the time is worth nothing.
    """

    def __init__(self, params: OutlookParams) -> None:
        self._weight = params.weight
        first: Mapping[str, Skill] = {kind: getattr(params, kind) for kind in KINDS}
        self._first = first
        self._mends = {kind: _Share(skill.mends, params.weight) for kind, skill in first.items()}
        self._keeps = {kind: _Share(skill.keeps, params.weight) for kind, skill in first.items()}
        self._changes = {kind: _Share(1.0, params.weight) for kind in KINDS}
        self._costs: dict[str, deque[Cost]] = {
            kind: deque(maxlen=params.memory) for kind in (THING, RELATION, NAME)
        }

    def gain(self, kind: str, p_right: float) -> float:
        """Return the probability that the reasoner adds to an answer right with ``p_right``."""
        mends, keeps = self._mends[kind].mean, self._keeps[kind].mean
        skill = replace(self._first[kind], mends=mends, keeps=keeps)
        return min(skill.gain(p_right), self._changes[kind].mean)

    def share(self, kind: str, budget: Budget) -> float:
        """Return the share of an hour's budget that a question takes: the mean of the last ones."""
        known = self._known(kind) or (ONE_CALL,)
        return sum(budget.share(one) for one in known) / len(known)

    def dearest(self, kind: str, budget: Budget) -> Cost:
        """Return the most that one of the last questions cost, and a call at least.

        Before any was paid it is a guess, and no reason to find the budget too small for ever.
        """
        known = self._known(kind)
        most = Cost(calls=1) if known else budget.capped(ONE_CALL)
        for one in known:
            most = most.at_least(one)
        return most

    def paid(self, kind: str, cost: Cost) -> None:
        """Learn what a question about a thing, a relation or a name cost."""
        self._costs[kind].append(cost)

    def told(self, kind: str, *, changed: bool) -> None:
        """Learn whether the reasoner says something else than the encoder."""
        self._changes[kind].add(changed)

    def judged(self, kind: str, *, fast_right: bool, reasoned_right: bool) -> None:
        """Learn from a question whose right answer is known."""
        share = self._keeps[kind] if fast_right else self._mends[kind]
        share.add(reasoned_right)

    def _known(self, kind: str) -> Collection[Cost]:
        """Return the costs of a kind; of two that are asked the same way one may stand in."""
        if kind == NAME:
            return self._costs[NAME]
        own, other = (RELATION, THING) if kind == RELATION else (THING, RELATION)
        return self._costs[own] or self._costs[other]


class _Share:
    """The mean of a Beta distribution: a first opinion, and what was counted."""

    def __init__(self, first: float, weight: float) -> None:
        self._yes = first * weight
        self._all = weight

    @property
    def mean(self) -> float:
        return self._yes / self._all

    def add(self, yes: bool) -> None:
        self._yes += yes
        self._all += 1.0
