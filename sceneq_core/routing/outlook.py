"""What a reasoner may be expected to change, and to cost."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field

from sceneq_core.checks import need_at_least, need_positive, need_within
from sceneq_core.routing.budget import Budget, Cost

THING, RELATION, ABSENCE, NAME = "thing", "relation", "absence", "name"
KINDS = (THING, RELATION, ABSENCE)
"""Questions about a thing alone, with a relation or a size, and those of either kind that the
encoder answers with "not found": a reasoner is of very different use to them."""

ONE_CALL = Cost(calls=1, tokens=2000)
"""What a question is taken to cost before one was paid: four pictures of 640x480 are about 1600
tokens to Qwen2.5-VL."""


@dataclass(frozen=True, slots=True)
class Skill:
    """``mends``: share of the encoder's wrong answers that the reasoner puts right; ``keeps``:
    share of its right answers that it leaves right.

    0.5 and 0.9 are an opinion, not a measurement; ``sceneq eval ablation --policies`` measures
    them for a reasoner and prints the lines for the graph.
    """

    mends: float = 0.5
    keeps: float = 0.9

    def __post_init__(self) -> None:
        need_within(self, 0, 1, "mends", "keeps")

    def gain(self, p_right: float) -> float:
        """Return how much more probably right an answer becomes that is so with ``p_right``."""
        return (1.0 - p_right) * self.mends - p_right * (1.0 - self.keeps)


@dataclass(frozen=True, slots=True)
class OutlookParams:
    """What is expected at first: a skill for each of ``KINDS``.

    ``weight``: how many questions that is worth beside what is learned; ``memory``: of how many of
    the last questions of a kind the cost is averaged.
    """

    thing: Skill = field(default_factory=Skill)
    relation: Skill = field(default_factory=Skill)
    absence: Skill = field(default_factory=Skill)
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
        self._mends = {kind: _Share(skill.mends, params.weight) for kind, skill in first.items()}
        self._keeps = {kind: _Share(skill.keeps, params.weight) for kind, skill in first.items()}
        self._changes = {kind: _Share(1.0, params.weight) for kind in KINDS}
        self._costs: dict[str, deque[Cost]] = {
            kind: deque(maxlen=params.memory) for kind in (THING, RELATION, NAME)
        }

    def gain(self, kind: str, p_right: float) -> float:
        """Return the probability that the reasoner adds to an answer right with ``p_right``."""
        skill = Skill(self._mends[kind].mean, self._keeps[kind].mean)
        return min(skill.gain(p_right), self._changes[kind].mean)

    def share(self, kind: str, budget: Budget) -> float:
        """Return the share of an hour's budget that a question takes: the mean of the last ones."""
        known = self._costs[THING if kind == ABSENCE else kind] or (ONE_CALL,)
        return sum(budget.share(one) for one in known) / len(known)

    def dearest(self, kind: str) -> Cost:
        """Return the most that one of the last questions cost, and a call at least."""
        most = Cost(calls=1) if self._costs[kind] else ONE_CALL
        for one in self._costs[kind]:
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
