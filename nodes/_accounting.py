"""What calls of a model cost, and a budget an hour that refuses more of them."""

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from sceneq_core.checks import need_at_least
from sceneq_core.reasoning.reasoner import NO_USAGE, Usage
from sceneq_core.routing.budget import HOUR_S, Budget, OverBudgetError


@dataclass(frozen=True, slots=True)
class Prices:
    """Money in any currency, the same everywhere: for a million tokens in and out, and a call."""

    per_million_in: float = 0.0
    per_million_out: float = 0.0
    per_call: float = 0.0

    def __post_init__(self) -> None:
        need_at_least(self, 0, "per_million_in", "per_million_out", "per_call")

    def of_tokens(self, tokens_in: int, tokens_out: int) -> Usage:
        """Return what tokens cost."""
        money = (tokens_in * self.per_million_in + tokens_out * self.per_million_out) / 1e6
        return Usage(tokens_in, tokens_out, money)


class _Entry(NamedTuple):
    at_s: float
    calls: int
    usage: Usage


class Ledger:
    """Books calls and tokens and keeps the last hour of them.

    A call is booked before it is made and its tokens when it has ended, so the calls under way may
    take tokens and money over the limit, by what they themselves cost.
    """

    def __init__(
        self, prices: Prices, budget: Budget, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._prices = prices
        self._budget = budget
        self._clock = clock
        self._lock = threading.Lock()
        self._hour: deque[_Entry] = deque()

    def begin_call(self) -> Usage:
        """Book one call and return its price.

        Raises:
            OverBudgetError: the budget does not allow one more.
        """
        price = Usage(money=self._prices.per_call)
        with self._lock:
            self._refuse_when_spent()
            self._hour.append(_Entry(self._clock(), 1, price))
        return price

    def cancel_call(self) -> Usage:
        """Take back a call that did not reach the server, and return its price, negative."""
        refund = Usage(money=-self._prices.per_call)
        with self._lock:
            self._hour.append(_Entry(self._clock(), -1, refund))
        return refund

    def end_call(self, tokens_in: int, tokens_out: int) -> Usage:
        """Book the tokens of a call and return what they cost."""
        usage = self._prices.of_tokens(tokens_in, tokens_out)
        with self._lock:
            self._hour.append(_Entry(self._clock(), 0, usage))
        return usage

    def last_hour(self) -> tuple[int, Usage]:
        """Return calls and usage of the last 60 minutes."""
        with self._lock:
            return self._spent()

    def _spent(self) -> tuple[int, Usage]:
        while self._hour and self._hour[0].at_s <= self._clock() - HOUR_S:
            self._hour.popleft()
        calls = sum(entry.calls for entry in self._hour)
        return calls, sum((entry.usage for entry in self._hour), NO_USAGE)

    def _refuse_when_spent(self) -> None:
        calls, usage = self._spent()
        tokens = usage.tokens_in + usage.tokens_out
        for spent, limit, what in (
            (calls, self._budget.calls_per_hour, "calls"),
            (tokens, self._budget.tokens_per_hour, "tokens"),
            (usage.money, self._budget.money_per_hour, "money"),
        ):
            if limit is not None and spent >= limit:
                raise OverBudgetError(self._said(f"{spent:g} of {limit:g} {what}"))

    def _said(self, spent: str) -> str:
        if not self._hour:
            return f"the budget is {spent} an hour"
        wait_s = self._hour[0].at_s + HOUR_S - self._clock()
        return f"the hour's budget is spent: {spent}; the oldest call leaves it in {wait_s:.0f} s"
