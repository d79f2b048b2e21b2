"""Whatever is asked and whenever: no hour holds more than the budget, and more budget helps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.routing.budget import HOUR_S, NOTHING, Budget, Cost, Ledger, OverBudgetError
from sceneq_core.routing.outlook import KINDS, THING, Outlook, OutlookParams, Skill
from sceneq_core.routing.policy import Case, PolicyParams, new_policy

COSTS = st.builds(
    Cost,
    calls=st.integers(0, 4),
    tokens=st.integers(0, 900),
    money=st.integers(0, 8).map(lambda n: n / 8),
)
GAPS_S = st.floats(0.0, 2 * HOUR_S)
BUDGETS = st.builds(
    Budget,
    calls_per_hour=st.none() | st.integers(0, 6),
    tokens_per_hour=st.none() | st.integers(0, 2000),
    money_per_hour=st.none() | st.integers(0, 16).map(lambda n: n / 8),
)


def within(budget: Budget, spent: list[tuple[float, Cost]]) -> bool:
    """Look at every 60 minutes that end with a payment."""
    return all(
        budget.holds(sum((cost for at_s, cost in spent if end_s - HOUR_S < at_s <= end_s), NOTHING))
        for end_s, _ in spent
    )


@given(BUDGETS, st.lists(st.tuples(GAPS_S, COSTS, st.floats(0.0, 600.0)), max_size=30))
def test_no_hour_holds_more_than_the_budget(budget, questions):
    """The model is paid at some moment between reservation and settlement."""
    ledger, spent, now_s = Ledger(budget), [], 0.0
    for gap_s, cost, takes_s in questions:
        now_s += gap_s
        try:
            ticket = ledger.reserve(cost, now_s)
        except OverBudgetError:
            wait_s = ledger.refill_s(cost, now_s)
            assert wait_s > 0.0
            continue
        paid_s = now_s + takes_s / 2
        now_s += takes_s
        ledger.settle(ticket, cost, now_s)
        spent.append((paid_s, cost))
    assert within(budget, spent)


@given(BUDGETS, st.lists(st.tuples(st.booleans(), st.floats(0.0, 1200.0), COSTS), max_size=30))
def test_many_at_once_share_the_budget(budget, steps):
    """Reservations overlap, and are settled late, for less or not at all."""
    ledger, open_tickets, spent, now_s = Ledger(budget), [], [], 0.0
    for opens, gap_s, cost in steps:
        now_s += gap_s
        if opens or not open_tickets:
            try:
                open_tickets.append((ledger.reserve(cost, now_s), cost, now_s))
            except OverBudgetError:
                continue
        else:
            ticket, reserved, from_s = open_tickets.pop(0)
            ledger.settle(ticket, reserved, now_s)
            spent.append(((from_s + now_s) / 2, reserved))
    assert within(budget, sorted(spent, key=lambda one: one[0]))


@given(BUDGETS, COSTS, st.lists(st.tuples(GAPS_S, COSTS), max_size=12))
def test_when_it_says_that_there_is_more_there_is(budget, wanted, booked):
    ledger, now_s = Ledger(budget), 0.0
    for gap_s, cost in booked:
        now_s += gap_s
        ledger.book(cost, now_s)
    wait_s = ledger.refill_s(wanted, now_s)
    if budget.holds(wanted):
        ledger.reserve(wanted, now_s + wait_s + 1e-6)
    else:
        assert wait_s == float("inf")


@given(
    st.integers(1, 20),
    st.lists(
        st.tuples(st.sampled_from(KINDS), st.floats(0.0, 1.0), st.floats(0.0, 1800.0)), max_size=60
    ),
)
def test_adaptive_never_spends_more_than_the_budget(calls, questions):
    budget = Budget(calls_per_hour=calls)
    spent, _ = play(budget, questions)
    assert within(budget, spent)


def play(
    budget: Budget, questions: list[tuple[str, float, float]], skill: Skill | None = None
) -> tuple[list[tuple[float, Cost]], float]:
    """Return what adaptive spends, and the gain of what it asks, on questions of (kind, p, gap)."""
    known = skill or Skill()
    params = PolicyParams(
        kind="adaptive", outlook=OutlookParams(thing=known, relation=known, absence=known)
    )
    outlook, ledger = Outlook(params.outlook), Ledger(budget)
    policy = new_policy(params, budget, outlook)
    now_s, spent, gained = 0.0, [], 0.0
    for kind, p_right, gap_s in questions:
        now_s += gap_s
        if not policy.decide(Case(kind, False, p_right), now_s).ask:
            continue
        try:
            ticket = ledger.reserve(Cost(calls=1), now_s)
        except OverBudgetError:
            continue
        ledger.settle(ticket, Cost(calls=1), now_s)
        policy.spend(Cost(calls=1), now_s)
        spent.append((now_s, Cost(calls=1)))
        gained += known.gain(p_right)
    return spent, gained


SURE = Skill(mends=1.0, keeps=1.0)
"""With it the gain of a question is 1 - p: what is best is known."""


def stream(seed: int, hours: int = 10) -> list[tuple[str, float, float]]:
    """A question a minute, each as likely to be easy as to be hard."""
    p = np.random.default_rng(seed).uniform(size=60 * hours)
    return [(THING, float(one), 60.0) for one in p]


@pytest.mark.parametrize("seed", range(5))
def test_more_budget_is_never_worse_on_a_known_problem(seed):
    questions = stream(seed)
    gains = [play(Budget(calls_per_hour=n), questions, SURE)[1] for n in (2, 4, 8, 16, 32, 60)]
    assert gains == sorted(gains)
    assert gains[-1] <= play(Budget(), questions, SURE)[1]


@pytest.mark.parametrize("calls", [6, 15, 30])
def test_adaptive_comes_close_to_the_best_that_could_be_done(calls):
    """The best: those that gain most among all, known beforehand. First come, first served: half
    of the budget's worth on average."""
    questions = stream(7)
    best = sorted((1.0 - p for _, p, _ in questions), reverse=True)[: 10 * calls]
    spent, gained = play(Budget(calls_per_hour=calls), questions, SURE)
    assert len(spent) <= 10 * calls
    assert gained >= 0.8 * sum(best)
    assert gained / len(spent) >= 1.3 * 0.5
