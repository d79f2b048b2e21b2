"""Which questions are worth the reasoner: gate, price and expected gain."""

import pytest

from sceneq_core.routing.budget import HOUR_S, Budget, Cost
from sceneq_core.routing.outlook import (
    ABSENCE,
    NAME,
    ONE_CALL,
    RELATION,
    THING,
    Outlook,
    OutlookParams,
    Skill,
)
from sceneq_core.routing.policy import (
    UNKNOWN,
    Case,
    Decision,
    PolicyParams,
    case_of,
    new_policy,
)
from sceneq_core.routing.price import Price, PriceParams

from support.furnished import router, snapshot

CALL = Cost(calls=1)
BUDGET = Budget(calls_per_hour=10)


def case(kind: str = THING, p_right: float = 0.5, *, enough: bool = False) -> Case:
    return Case(kind, enough, p_right)


def adaptive(budget: Budget = BUDGET, **outlook: object):
    params = PolicyParams(kind="adaptive", outlook=OutlookParams(**outlook))
    known = Outlook(params.outlook)
    return new_policy(params, budget, known), known


@pytest.mark.parametrize(
    ("kind", "unsure", "sure"),
    [("thresholds", True, False), ("always", True, True), ("never", False, False)],
)
def test_fixed_policies_do_not_look_at_money(kind, unsure, sure):
    policy = new_policy(PolicyParams(kind=kind), BUDGET, Outlook(OutlookParams()))
    policy.spend(Cost(calls=1000), 0.0)
    assert policy.price(0.0) is None
    assert policy.decide(case(enough=False), 0.0) == Decision(unsure)
    assert policy.decide(case(enough=True), 0.0) == Decision(sure)


def test_the_gain_is_what_is_mended_less_what_is_spoilt():
    skill = Skill(mends=0.5, keeps=0.9)
    assert skill.gain(0.0) == pytest.approx(0.5, abs=1e-5)
    assert skill.gain(1.0) == pytest.approx(-0.1, abs=1e-5)
    assert skill.gain(0.4) == pytest.approx(0.6 * 0.5 - 0.4 * 0.1)


def test_the_price_rises_with_spending_and_falls_with_time():
    price = Price(PriceParams(first=0.1, swing=1.0, aim=1.0))
    assert price.at(1000.0) == 0.1
    assert price.at(1000.0 + 0.05 * HOUR_S) == pytest.approx(0.05)
    price.spend(0.2, 1000.0 + 0.05 * HOUR_S)
    assert price.at(1000.0 + 0.05 * HOUR_S) == pytest.approx(0.25)
    assert price.at(1000.0 + 0.15 * HOUR_S) == pytest.approx(0.15)
    assert price.at(1000.0 + HOUR_S) == 0.0
    price.spend(7.0, 5000.0)
    assert price.at(5000.0) == 1.0


def test_the_price_steers_for_a_little_less_than_the_budget():
    price = Price(PriceParams(first=0.5, swing=2.0, aim=0.9))
    assert price.at(0.0) == 0.5
    assert price.at(0.1 * HOUR_S) == pytest.approx(0.5 - 2.0 * 0.9 * 0.1)


def test_p_is_corrected_for_the_kind_of_question():
    assert Skill().corrected(0.7) == pytest.approx(0.7)
    assert Skill(scale=0.0, bias=0.0).corrected(0.99) == 0.5
    assert Skill(scale=0.5).corrected(0.8) == pytest.approx(2 / 3)  # odds 4 become 2
    assert Skill(bias=-2.0).corrected(0.5) == pytest.approx(0.1192, abs=1e-4)
    assert OutlookParams().relation.corrected(0.8) < OutlookParams().thing.corrected(0.8)


def test_adaptive_asks_where_the_gain_is_above_the_price():
    policy, _ = adaptive()
    assert policy.decide(case(p_right=0.2), 0.0) == Decision(ask=True)  # gain 0.38, price 0.1
    for _ in range(4):
        policy.spend(CALL, 0.0)
    assert policy.price(0.0) == pytest.approx(0.5)
    dear = policy.decide(case(p_right=0.2), 0.0)
    assert dear == Decision(
        ask=False, why_not="a reasoner would gain 0.38, which is not worth it at a price of 0.50"
    )
    assert policy.decide(case(p_right=0.2), 0.2 * HOUR_S).ask  # the price is 0.32


def test_adaptive_asks_about_a_sure_answer_too_when_the_reasoner_is_better():
    policy, _ = adaptive(relation=Skill(mends=0.9, keeps=1.0))
    assert policy.decide(case(RELATION, 0.6, enough=True), 0.0).ask
    assert not policy.decide(case(THING, 0.9, enough=False), 0.0).ask


def test_without_a_budget_any_gain_is_worth_it():
    policy, _ = adaptive(Budget())
    for _ in range(100):
        policy.spend(Cost(calls=3, tokens=5000), 0.0)
    assert policy.decide(case(p_right=0.75), 0.0).ask  # gain 0.05
    assert not policy.decide(case(p_right=0.9), 0.0).ask  # gain -0.04


def test_what_costs_nothing_is_asked_for_any_gain():
    policy, outlook = adaptive()
    policy.spend(Cost(calls=10), 0.0)
    assert not policy.decide(case(RELATION, 0.5), 0.0).ask
    outlook.paid(RELATION, Cost())
    assert policy.decide(case(RELATION, 0.5), 0.0).ask
    assert policy.decide(case(THING, 0.5), 0.0).ask  # it is asked the same way
    outlook.paid(THING, Cost(calls=1))
    assert not policy.decide(case(THING, 0.5), 0.0).ask


def test_a_dearer_kind_must_gain_more():
    policy, outlook = adaptive()
    for cost, kind in ((1, THING), (3, RELATION)):
        outlook.paid(kind, Cost(calls=cost))
    policy.spend(Cost(calls=2), 0.0)  # price 0.3 of the usual two calls
    assert policy.decide(case(THING, 0.4), 0.0).ask  # gain 0.26, price 0.15
    assert not policy.decide(case(RELATION, 0.4), 0.0).ask  # price 0.45


def test_a_budget_of_nothing_has_the_full_price():
    policy, _ = adaptive(Budget(calls_per_hour=0))
    assert policy.decide(case(p_right=0.0), 0.0).ask  # the ledger will refuse what costs a call
    policy.spend(CALL, 0.0)
    assert policy.price(0.0) == 1.0


def test_the_outlook_learns_costs_and_changes():
    outlook = Outlook(OutlookParams(memory=2))
    assert outlook.dearest(THING, BUDGET) == ONE_CALL
    for calls in (5, 1, 2):
        outlook.paid(THING, Cost(calls=calls))
    assert outlook.dearest(THING, BUDGET) == Cost(calls=2)  # the five are forgotten
    assert outlook.share(THING, BUDGET) == pytest.approx(0.15)
    assert outlook.share(ABSENCE, BUDGET) == outlook.share(THING, BUDGET)
    assert outlook.dearest(NAME, BUDGET) == ONE_CALL
    assert outlook.dearest(NAME, Budget(tokens_per_hour=900)) == Cost(calls=1, tokens=900)
    assert outlook.dearest(NAME, Budget(tokens_per_hour=0)) == ONE_CALL
    for _ in range(990):
        outlook.told(THING, changed=False)
    assert outlook.gain(THING, 0.0) == pytest.approx(10 / 1000)  # it agrees with the encoder
    assert outlook.gain(ABSENCE, 0.0) == pytest.approx(0.3, abs=1e-5)


def test_the_outlook_learns_from_truth_where_there_is_some():
    outlook = Outlook(OutlookParams())
    for _ in range(10):
        outlook.judged(THING, fast_right=False, reasoned_right=True)
    assert outlook.gain(THING, 0.0) == pytest.approx(0.75, abs=1e-5)
    for _ in range(10):
        outlook.judged(THING, fast_right=True, reasoned_right=False)
    assert outlook.gain(THING, 1.0) == pytest.approx(0.45 - 1.0, abs=1e-5)


def test_a_case_is_read_from_the_answer():
    brain, scene = router(), snapshot()
    for text, kind in (
        ("lamp", THING),
        ("the cup on the coffee table", RELATION),
        ("xylophone", ABSENCE),
    ):
        question = brain.read(text)
        routed = brain.answer(scene, question)
        seen = case_of(routed, question)
        assert (seen.kind, seen.enough) == (kind, routed.enough)
        assert seen.p_right == (UNKNOWN if kind == ABSENCE else routed.answer.p_right)


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: PolicyParams(kind="greedy"), "greedy"),
        (lambda: PolicyParams(min_gain=2.0), "min_gain"),
        (lambda: PriceParams(swing=0.0), "swing"),
        (lambda: PriceParams(first=1.5), "first"),
        (lambda: PriceParams(aim=0.0), "aim"),
        (lambda: Skill(scale=-1.0), "scale"),
        (lambda: Skill(bias=11.0), "bias"),
        (lambda: Skill(mends=-0.1), "mends"),
        (lambda: OutlookParams(weight=0.0), "weight"),
        (lambda: OutlookParams(memory=0), "memory"),
    ],
)
def test_bad_parameters_are_named(make, name):
    with pytest.raises(ValueError, match=name):
        make()
