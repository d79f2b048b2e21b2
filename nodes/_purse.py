"""The scene's budget for reasoning, and the policy that spends it; used by many threads."""

import math
import threading
import time
from collections.abc import Callable
from typing import Any, TypeVar

from sceneq_core.reasoning.reasoner import LabelVerdict, UnansweredError, Verdict
from sceneq_core.routing.budget import Budget, Cost, Ledger, OverBudgetError
from sceneq_core.routing.outlook import Outlook
from sceneq_core.routing.policy import Case, Decision, PolicyParams, new_policy
from sceneq_nodes._bus import Bus

V = TypeVar("V", bound=Verdict | LabelVerdict)


class LostVerdictError(UnansweredError):
    """Somebody was asked, but what he said did not arrive: nobody knows what it cost."""


class Purse:
    """Pays for verdicts. What is spent is kept in memory: a restarted node begins a new hour."""

    def __init__(
        self,
        bus: Bus,
        budget: Budget,
        policy: PolicyParams,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._bus = bus
        self._clock = clock
        self._lock = threading.Lock()
        self._ledger = Ledger(budget)
        self._outlook = Outlook(policy.outlook)
        self._policy = new_policy(policy, budget, self._outlook)
        self._kind = policy.kind

    def decide(self, case: Case) -> Decision:
        """Return whether a question is worth the reasoner."""
        with self._lock:
            decision = self._policy.decide(case, self._clock())
        if decision.why_not:
            self._bus.count("reasoner_not_worth_it")
        return decision

    def told(self, case: Case, *, changed: bool) -> None:
        """Learn whether the reasoner said something else than the encoder."""
        with self._lock:
            self._outlook.told(case.kind, changed=changed)

    def pay(self, kind: str, ask: Callable[[bool], V]) -> V:
        """Return ``ask(may_spend)`` and book its cost.

        When the budget is spent, only a reasoner that costs nothing may answer.

        Raises:
            UnansweredError: it did not answer, or would have cost too much.
        """
        try:
            with self._lock:
                expected = self._outlook.dearest(kind, self._ledger.budget)
                ticket = self._ledger.reserve(expected, self._clock())
        except OverBudgetError as over:
            return self._for_nothing(kind, ask, over)
        cost = expected
        try:
            verdict = ask(True)
            cost = Cost.of(verdict.vlm_calls, verdict.usage)
            self._learn(kind, cost)
            return verdict
        except LostVerdictError:
            raise
        except UnansweredError as error:
            cost = Cost.of(error.vlm_calls, error.usage)
            raise
        finally:
            with self._lock:
                self._ledger.settle(ticket, cost, self._clock())
                self._policy.spend(cost, self._clock())

    def status(self) -> dict[str, Any]:
        """Return what was spent of what, and when there is some again."""
        with self._lock:
            now_s = self._clock()
            spent, budget = self._ledger.spent(now_s), self._ledger.budget
            wait_s = self._ledger.refill_s(Cost(calls=1), now_s)
            price = self._policy.price(now_s)
        limits = {f"{name}_per_hour": limit for _, limit, name in budget.limits(spent)}
        return {
            "policy": self._kind,
            "calls": spent.calls,
            "tokens": spent.tokens,
            "money": round(spent.money, 6),
            **limits,
            "refills_in_s": None if math.isinf(wait_s) else round(wait_s, 1),
            **({} if price is None else {"price": round(price, 4)}),
        }

    def _for_nothing(self, kind: str, ask: Callable[[bool], V], over: OverBudgetError) -> V:
        try:
            verdict = ask(False)
        except UnansweredError as error:
            self._bus.count("reasoner_over_budget")
            self._book(Cost.of(error.vlm_calls, error.usage))
            raise UnansweredError(str(over), error.vlm_calls, error.usage) from error
        cost = Cost.of(verdict.vlm_calls, verdict.usage)
        self._book(cost)
        self._learn(kind, cost)
        return verdict

    def _book(self, cost: Cost) -> None:
        """Book what should have cost nothing."""
        with self._lock:
            self._ledger.book(cost, self._clock())
            self._policy.spend(cost, self._clock())

    def _learn(self, kind: str, cost: Cost) -> None:
        with self._lock:
            self._outlook.paid(kind, cost)
