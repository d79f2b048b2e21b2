"""What a scene may spend on models in an hour, and the ledger of what it has spent.

No clock: whoever books says when, ``now_s`` in seconds of any one clock that never goes back.
"""

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

from sceneq_core.checks import need_at_least
from sceneq_core.reasoning.reasoner import Usage

HOUR_S = 3600.0


@dataclass(frozen=True, slots=True)
class Cost:
    """Calls of a model, tokens read and written, and money in the currency of the prices."""

    calls: int = 0
    tokens: int = 0
    money: float = 0.0

    def __add__(self, other: "Cost") -> "Cost":
        return Cost(self.calls + other.calls, self.tokens + other.tokens, self.money + other.money)

    @classmethod
    def of(cls, calls: int, usage: Usage) -> "Cost":
        """Return what so many calls of this usage cost."""
        return cls(calls, usage.tokens_in + usage.tokens_out, usage.money)

    def at_least(self, other: "Cost") -> "Cost":
        """Return the greater of both in each of the three."""
        return Cost(
            max(self.calls, other.calls),
            max(self.tokens, other.tokens),
            max(self.money, other.money),
        )


NOTHING = Cost()


@dataclass(frozen=True, slots=True)
class Budget:
    """The most in any 60 minutes; ``None`` = no limit. 0 calls = never ask what costs a call."""

    calls_per_hour: int | None = None
    tokens_per_hour: int | None = None
    money_per_hour: float | None = None

    def __post_init__(self) -> None:
        for name in ("calls_per_hour", "tokens_per_hour", "money_per_hour"):
            if getattr(self, name) is not None:
                need_at_least(self, 0, name)

    def share(self, cost: Cost) -> float:
        """Return the largest share of an hour's budget that ``cost`` takes; 0 without limits.

        Of a budget of nothing, anything is infinitely much.
        """
        shares = [_share(amount, limit) for amount, limit, _ in self.limits(cost)]
        return max(shares, default=0.0)

    def holds(self, cost: Cost) -> bool:
        """Return whether ``cost`` is within every limit."""
        return all(amount <= limit for amount, limit, _ in self.limits(cost))

    def capped(self, cost: Cost) -> Cost:
        """Return ``cost``, or where it is above a limit other than 0, that limit."""
        return Cost(
            int(_capped(cost.calls, self.calls_per_hour)),
            int(_capped(cost.tokens, self.tokens_per_hour)),
            _capped(cost.money, self.money_per_hour),
        )

    def limits(self, cost: Cost) -> Iterator[tuple[float, float, str]]:
        """Yield amount, limit and name of everything that is limited."""
        for amount, limit, name in (
            (cost.calls, self.calls_per_hour, "calls"),
            (cost.tokens, self.tokens_per_hour, "tokens"),
            (cost.money, self.money_per_hour, "money"),
        ):
            if limit is not None:
                yield amount, limit, name


class OverBudgetError(Exception):
    """The budget does not allow it; the text says what is spent and when there is some again."""


class Ledger:
    """A sliding window of 60 minutes: nothing is reserved that would take it over the budget.

    A cost is reserved before it is known and settled when it is. It counts from its reservation
    until an hour after it was settled, so wherever in between the model was really paid, no 60
    minutes hold more than the budget, as long as nothing costs more than was reserved for it.
    """

    def __init__(self, budget: Budget) -> None:
        self.budget = budget
        self._reserved: dict[int, Cost] = {}
        self._settled: deque[tuple[float, Cost]] = deque()
        self._settled_sum: Cost | None = NOTHING
        self._tickets = 0

    def reserve(self, cost: Cost, now_s: float) -> int:
        """Set ``cost`` aside and return the ticket to settle it with.

        Raises:
            OverBudgetError: the hour has too little left.
        """
        if not self.budget.holds(self.spent(now_s) + cost):
            raise OverBudgetError(self._refusal(cost, now_s))
        self._tickets += 1
        self._reserved[self._tickets] = cost
        return self._tickets

    def settle(self, ticket: int, cost: Cost, now_s: float) -> None:
        """Book what it really cost; a ticket is settled once.

        Raises:
            KeyError: no such reservation.
        """
        del self._reserved[ticket]
        self.book(cost, now_s)

    def book(self, cost: Cost, now_s: float) -> None:
        """Book what nobody reserved: it was spent all the same."""
        if cost != NOTHING:
            self._settled.append((now_s, cost))
            self._settled_sum = None

    def spent(self, now_s: float) -> Cost:
        """Return what the last 60 minutes cost, reservations included."""
        self._forget(now_s)
        if self._settled_sum is None:
            self._settled_sum = sum((cost for _, cost in self._settled), NOTHING)
        return sum(self._reserved.values(), self._settled_sum)

    def refill_s(self, cost: Cost, now_s: float) -> float:
        """Return in how many seconds ``cost`` fits again; infinite when it never will.

        What is reserved is taken to be settled now.
        """
        spent = self.spent(now_s)
        if self.budget.holds(spent + cost):
            return 0.0
        pending = [(now_s, reserved) for reserved in self._reserved.values()]
        leaving = [*self._settled, *pending]
        for row, (at_s, _) in enumerate(leaving, 1):
            left = sum((one for _, one in leaving[row:]), NOTHING)
            if self.budget.holds(left + cost):
                return at_s + HOUR_S - now_s
        return math.inf

    def _refusal(self, cost: Cost, now_s: float) -> str:
        spent = self.spent(now_s)
        over = self.budget.limits(spent + cost)
        used = {name: amount for amount, _, name in self.budget.limits(spent)}
        names = [f"{used[name]:g} of {limit:g} {name}" for n, limit, name in over if n > limit]
        wait_s = self.refill_s(cost, now_s)
        again = "it never allows one" if math.isinf(wait_s) else f"refills in {wait_s:.0f} s"
        return f"the scene's budget of this hour is spent: {', '.join(names)}; {again}"

    def _forget(self, now_s: float) -> None:
        """Drop what is an hour old."""
        while self._settled and self._settled[0][0] <= now_s - HOUR_S:
            self._settled.popleft()
            self._settled_sum = None


def _capped(amount: float, limit: float | None) -> float:
    return min(amount, limit) if limit else amount


def _share(amount: float, limit: float) -> float:
    if not amount:
        return 0.0
    return amount / limit if limit else math.inf
