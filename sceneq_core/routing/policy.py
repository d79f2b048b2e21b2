"""Which questions are worth a reasoner?

``thresholds`` is the paper's gate: those that the encoder's answer does not pass. ``adaptive``
compares what a verdict is expected to gain with what it costs while the budget lasts. ``always``
and ``never`` are the ends of the scale. docs/budget.md.
"""

import math
from dataclasses import dataclass, field
from typing import Protocol

from sceneq_core.checks import need_within
from sceneq_core.routing.answer import NOT_FOUND
from sceneq_core.routing.budget import Budget, Cost
from sceneq_core.routing.outlook import ABSENCE, RELATION, THING, Outlook, OutlookParams
from sceneq_core.routing.price import Price, PriceParams
from sceneq_core.routing.question import Question
from sceneq_core.routing.router import Routed

UNKNOWN = 0.5
"""That "not found" is right, where no calibration tells how probable "none of them" is."""

POLICIES = ("thresholds", "adaptive", "always", "never")


@dataclass(frozen=True, slots=True)
class Case:
    """A question as a policy sees it.

    ``enough``: the encoder's answer passes the gate; ``p_right``: the probability that it is right;
    ``kind``: one of ``outlook.KINDS``.
    """

    kind: str
    enough: bool
    p_right: float


@dataclass(frozen=True, slots=True)
class Decision:
    """Whether to ask the reasoner, and why not, "" when the encoder's answer says so itself."""

    ask: bool
    why_not: str = ""


class Policy(Protocol):
    """Decides question by question; ``now_s`` as in ``budget``."""

    def decide(self, case: Case, now_s: float) -> Decision:
        """Return whether the question is worth the reasoner."""

    def spend(self, cost: Cost, now_s: float) -> None:
        """Take note of what a question cost."""

    def price(self, now_s: float) -> float | None:
        """Return the gain that a question must promise now; ``None`` = no such thing."""


@dataclass(frozen=True, slots=True)
class PolicyParams:
    """``kind`` is one of ``POLICIES``; the rest is for ``adaptive``.

    ``min_gain``: a smaller gain is not worth the wait, whatever the budget.
    """

    kind: str = "thresholds"
    min_gain: float = 0.02
    price: PriceParams = field(default_factory=PriceParams)
    outlook: OutlookParams = field(default_factory=OutlookParams)

    def __post_init__(self) -> None:
        need_within(self, 0, 1, "min_gain")
        if self.kind not in POLICIES:
            raise ValueError(f"kind: unknown {self.kind!r}, known: {', '.join(POLICIES)}")


def new_policy(params: PolicyParams, budget: Budget, outlook: Outlook) -> Policy:
    """Return the policy that ``params`` name."""
    if params.kind == "adaptive":
        return Adaptive(params, budget, outlook)
    fixed: dict[str, Policy] = {
        "thresholds": Thresholds(),
        "always": Always(),
        "never": Never(),
    }
    return fixed[params.kind]


def case_of(routed: Routed, question: Question) -> Case:
    """Return what a policy needs to know of the encoder's answer."""
    kind = RELATION if question.phrase.constraints else THING
    if routed.answer.status == NOT_FOUND:
        kind = ABSENCE
    p_right = routed.answer.p_right
    if kind == ABSENCE and not p_right:
        p_right = UNKNOWN
    return Case(kind, routed.enough, p_right)


class _Fixed:
    """A policy that does not look at money."""

    def spend(self, cost: Cost, now_s: float) -> None:
        """Nothing changes."""

    def price(self, now_s: float) -> float | None:
        """There is none."""
        return None


class Thresholds(_Fixed):
    """Asks exactly where the gate does not accept the encoder's answer."""

    def decide(self, case: Case, now_s: float) -> Decision:
        """Return what the gate says."""
        return Decision(not case.enough)


class Always(_Fixed):
    """Asks every time."""

    def decide(self, case: Case, now_s: float) -> Decision:
        """Return yes."""
        return Decision(ask=True)


class Never(_Fixed):
    """Never asks."""

    def decide(self, case: Case, now_s: float) -> Decision:
        """Return no."""
        return Decision(ask=False)


class Adaptive:
    """Asks where the expected gain is worth the price of the call.

    gain = P(reasoner right) - P(encoder right); the price is that of a question of usual cost, so
    a dearer kind must gain as much more. What costs nothing is asked for any gain.
    """

    def __init__(self, params: PolicyParams, budget: Budget, outlook: Outlook) -> None:
        self._min_gain = params.min_gain
        self._budget = budget
        self._outlook = outlook
        self._price = Price(params.price)

    def decide(self, case: Case, now_s: float) -> Decision:
        """Return whether the gain is above the price."""
        gain = self._outlook.gain(case.kind, case.p_right)
        least = max(self._min_gain, self._price.at(now_s) * self._dearness(case.kind))
        if gain > 0.0 and gain >= least:
            return Decision(ask=True)
        why_not = f"a reasoner would gain {max(gain, 0.0):.2f}, which is not worth it"
        return Decision(ask=False, why_not=f"{why_not} at a price of {least:.2f}")

    def spend(self, cost: Cost, now_s: float) -> None:
        """Let the price follow the share of the budget that was spent."""
        self._price.spend(self._budget.share(cost), now_s)

    def price(self, now_s: float) -> float | None:
        """Return the price of a question of usual cost."""
        return self._price.at(now_s)

    def _dearness(self, kind: str) -> float:
        """Return what a kind costs beside the usual question about a thing or a relation."""
        share = self._outlook.share(kind, self._budget)
        usual = [self._outlook.share(one, self._budget) for one in (THING, RELATION)]
        mean = sum(usual) / len(usual)
        if not share or not mean or math.isinf(mean):
            return float(share > 0.0)
        return share / mean
