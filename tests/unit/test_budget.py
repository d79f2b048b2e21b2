"""The ledger of an hour, by hand."""

import math

import pytest

from sceneq_core.reasoning.reasoner import Usage
from sceneq_core.routing.budget import HOUR_S, NOTHING, Budget, Cost, Ledger, OverBudgetError


def spend(ledger: Ledger, cost: Cost, now_s: float) -> None:
    ledger.settle(ledger.reserve(cost, now_s), cost, now_s)


def test_a_window_slides():
    ledger = Ledger(Budget(calls_per_hour=2))
    spend(ledger, Cost(calls=1), 0.0)
    spend(ledger, Cost(calls=1), 600.0)
    assert ledger.spent(600.0) == Cost(calls=2)
    with pytest.raises(OverBudgetError, match=r"2 of 2 calls; refills in 2000 s"):
        ledger.reserve(Cost(calls=1), 1600.0)
    assert ledger.refill_s(Cost(calls=1), 1600.0) == 2000.0
    assert ledger.refill_s(Cost(calls=2), 1600.0) == 2600.0
    spend(ledger, Cost(calls=1), HOUR_S)
    assert ledger.spent(HOUR_S) == Cost(calls=2)
    assert ledger.spent(600.0 + HOUR_S) == Cost(calls=1)


def test_what_is_reserved_counts_until_it_is_settled():
    ledger = Ledger(Budget(calls_per_hour=3))
    ticket = ledger.reserve(Cost(calls=3), 0.0)
    assert ledger.refill_s(Cost(calls=1), 50.0) == HOUR_S
    with pytest.raises(OverBudgetError):
        ledger.reserve(Cost(calls=1), 2 * HOUR_S)  # it is still under way
    ledger.settle(ticket, Cost(calls=1), 2 * HOUR_S)
    assert ledger.spent(2 * HOUR_S) == Cost(calls=1)
    ledger.reserve(Cost(calls=2), 2 * HOUR_S)
    with pytest.raises(KeyError):
        ledger.settle(ticket, NOTHING, 2 * HOUR_S)


def test_a_cost_leaves_an_hour_after_it_was_settled():
    ledger = Ledger(Budget(calls_per_hour=1))
    ticket = ledger.reserve(Cost(calls=1), 0.0)
    ledger.settle(ticket, Cost(calls=1), 100.0)
    assert ledger.refill_s(Cost(calls=1), HOUR_S) == 100.0
    assert ledger.refill_s(Cost(calls=1), HOUR_S + 100.0) == 0.0


def test_tokens_and_money_are_limits_of_their_own():
    ledger = Ledger(Budget(tokens_per_hour=1000, money_per_hour=0.5))
    spend(ledger, Cost.of(1, Usage(700, 100, 0.25)), 0.0)
    with pytest.raises(OverBudgetError, match="800 of 1000 tokens; refills in 3600 s"):
        ledger.reserve(Cost(tokens=201), 0.0)
    with pytest.raises(OverBudgetError, match=r"0.25 of 0.5 money"):
        ledger.reserve(Cost(money=0.26), 0.0)
    spend(ledger, Cost(calls=99, tokens=200, money=0.25), 0.0)


def test_what_is_above_the_budget_of_an_hour_never_comes():
    ledger = Ledger(Budget(calls_per_hour=0))
    assert math.isinf(ledger.refill_s(Cost(calls=1), 0.0))
    with pytest.raises(OverBudgetError, match="0 of 0 calls; it never allows one"):
        ledger.reserve(Cost(calls=1), 0.0)
    ledger.reserve(NOTHING, 0.0)


def test_what_was_spent_all_the_same_is_booked():
    ledger = Ledger(Budget(calls_per_hour=1))
    ledger.book(Cost(calls=5), 0.0)
    assert ledger.spent(0.0) == Cost(calls=5)
    assert ledger.refill_s(Cost(calls=1), 0.0) == HOUR_S


def test_the_share_is_that_of_the_scarcest():
    budget = Budget(calls_per_hour=10, tokens_per_hour=1000)
    assert budget.share(Cost(calls=1, tokens=500)) == 0.5
    assert budget.share(NOTHING) == 0.0
    assert Budget().share(Cost(calls=1, tokens=500, money=9.0)) == 0.0
    assert math.isinf(Budget(money_per_hour=0).share(Cost(money=0.1)))


@pytest.mark.parametrize("name", ["calls_per_hour", "tokens_per_hour", "money_per_hour"])
def test_a_negative_budget_is_refused(name):
    with pytest.raises(ValueError, match=name):
        Budget(**{name: -1})
