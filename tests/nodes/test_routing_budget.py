"""The routing node spends its budget, says so, and asks nobody twice."""

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest

from sceneq_core.reasoning.geometric import GeometricParams, GeometricReasoner
from sceneq_core.reasoning.reasoner import (
    LabelProblem,
    LabelVerdict,
    UnansweredError,
    Usage,
    Verdict,
)
from sceneq_core.routing.budget import Budget
from sceneq_core.routing.outlook import OutlookParams, Skill
from sceneq_core.routing.policy import PolicyParams
from sceneq_core.routing.price import PriceParams
from sceneq_core.routing.remembered import RememberedParams
from sceneq_nodes._backends import BACKENDS
from sceneq_nodes._bus import QueryError, Reply
from sceneq_nodes._reason_json import any_problem_from_bytes, verdict_bytes
from sceneq_schemas.topics import QUERY_LABEL, QUERY_STATUS, REASON

from support.furnished import ROOM
from support.furnished_node import RoutingHome

ONE, TWO = "the cup on the coffee table", "the pillow on the couch"
FREE = GeometricReasoner(GeometricParams())


class Model:
    """A reasoner that costs a call, answers as geometry does, and obeys ``may_spend``."""

    def __init__(self, calls: int = 1, obeys: bool = True) -> None:
        self.problems = []
        self.calls = calls
        self.obeys = obeys
        self.gate = threading.Event()
        self.gate.set()

    def __call__(self, request):
        problem = any_problem_from_bytes(request.payload)
        self.problems.append(problem)
        assert self.gate.wait(10.0)
        if self.obeys and not problem.may_spend:
            return reply(UnansweredError("a call of a model is not allowed now"))
        paid = {"vlm_calls": self.calls, "usage": Usage(800, 10, 0.01)}
        if isinstance(problem, LabelProblem):
            return reply(replace(FREE.label(problem), **paid))
        return reply(replace(FREE.solve(problem), **paid))


def reply(verdict: Verdict | LabelVerdict | UnansweredError) -> Reply:
    return Reply(verdict_bytes(verdict), REASON.encoding)


@pytest.fixture(autouse=True)
def plug_in_the_word_encoder(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setitem(BACKENDS["encoder"], "words", "support.furnished:WordEncoder")


def home(model=None, **params) -> RoutingHome:
    place = RoutingHome(**params)
    place.bus.answer(REASON, model or Model())
    return place


def spending(place: RoutingHome) -> dict:
    return place.query(QUERY_STATUS)["reasoning"]


def test_an_exhausted_budget_gives_the_encoders_answer_and_says_when_there_is_more():
    model = Model()
    place = home(model, budget=Budget(calls_per_hour=1))
    first, second = place.ask(ONE), place.ask(TWO)
    assert (first["route"], first["cost"]["vlm_calls"]) == ("reasoned", 1)
    assert (second["route"], second["cost"]["vlm_calls"]) == ("fallback", 0)
    said = "the scene's budget of this hour is spent: 1 of 1 calls; refills in 3"
    assert second["reason"].startswith(said)
    assert second["instances"]
    assert [one.may_spend for one in model.problems] == [True, False]
    assert place.bus.counters["reasoner_over_budget"] == 1
    told = spending(place)
    assert (told["policy"], told["calls"], told["calls_per_hour"]) == ("thresholds", 1, 1)
    assert (told["tokens"], told["money"]) == (810, 0.01)
    assert 3500 < told["refills_in_s"] <= 3600


def test_tokens_and_money_are_budgets_too():
    for budget in (Budget(tokens_per_hour=2500), Budget(money_per_hour=0.015)):
        place = home(budget=budget)
        assert [place.ask(q)["route"] for q in (ONE, TWO)] == ["reasoned", "fallback"] or (
            budget.tokens_per_hour
        )
    assert place.ask("the box under the chair")["route"] == "fallback"


def test_what_costs_nothing_is_always_allowed():
    place = home(lambda r: reply(FREE.solve(any_problem_from_bytes(r.payload))))
    free = home(
        lambda r: reply(FREE.solve(any_problem_from_bytes(r.payload))),
        budget=Budget(calls_per_hour=0),
    )
    for question in (ONE, TWO):
        rich, poor = place.ask(question), free.ask(question)
        assert (poor["route"], poor["instances"]) == ("reasoned", rich["instances"])
    assert spending(free)["refills_in_s"] is None
    assert spending(free)["calls"] == 0


def test_what_was_spent_without_leave_is_booked():
    place = home(Model(obeys=False), budget=Budget(calls_per_hour=0))
    assert place.ask(ONE)["cost"]["vlm_calls"] == 1
    assert spending(place)["calls"] == 1


def test_a_dearer_question_than_expected_lowers_what_is_left():
    model = Model(calls=3)
    place = home(model, budget=Budget(calls_per_hour=4))
    assert place.ask(ONE)["cost"]["vlm_calls"] == 3
    assert place.ask(TWO)["route"] == "fallback"  # one call is left, a question takes three
    assert spending(place)["calls"] == 3


def test_a_failure_costs_what_it_says_and_a_lost_verdict_what_was_expected():
    def fail(request):
        return reply(UnansweredError("no reply in time", 2, Usage(100, 0, 0.0)))

    def lose(request):
        raise QueryError("timeout", "no reply in time")

    for answer, calls in ((fail, 2), (lose, 1), (lambda request: None, 0)):
        place = home(answer, budget=Budget(calls_per_hour=9))
        assert place.ask(ONE)["route"] == "fallback"
        assert spending(place)["calls"] == calls


def test_naming_is_paid_from_the_same_purse():
    place = home(Model(calls=3), budget=Budget(calls_per_hour=3))
    named = place.query(QUERY_LABEL, id="6", mode="reason")
    assert (named["route"], named["cost"]["vlm_calls"], named["cached"]) == ("reasoned", 3, False)
    assert place.ask(ONE)["route"] == "fallback"
    again = place.query(QUERY_LABEL, id="6", mode="reason")
    assert (again["route"], again["cost"]["vlm_calls"], again["cached"]) == ("reasoned", 0, True)


def test_the_same_question_is_answered_from_memory_until_its_things_change():
    model = Model()
    place = home(model, budget=Budget(calls_per_hour=1))
    first, again = place.ask(ONE), place.ask(ONE.upper())
    assert [one["cached"] for one in (first, again)] == [False, True]
    assert (again["route"], again["cost"]["vlm_calls"]) == ("reasoned", 0)
    assert again["instances"] == first["instances"]
    place.show((*ROOM, ROOM[1]._replace(name="mailbox")))  # elsewhere, not a candidate
    assert place.bus.counters["verdicts_cached"] == 1
    cup = ROOM[5]
    moved = cup._replace(low=(-1.4, 0.6, 0.45), high=(-1.3, 0.7, 0.55))
    place.show((*ROOM[:5], moved, *ROOM[6:]))
    assert place.ask(ONE)["route"] == "fallback"  # asked anew, and there is no budget left
    assert len(model.problems) == 2


def test_what_is_remembered_says_the_same_as_when_it_was_paid_for():
    """Also where the encoder says that there is no such thing: the model has looked."""
    place = home(lambda request: reply(Verdict(((6, 1.0),), "seen", 1)))
    first, again = (place.ask("grand piano", mode="reason") for _ in range(2))
    assert [one["cached"] for one in (first, again)] == [False, True]
    for name in ("status", "instances", "confidence", "reason"):
        assert first[name] == again[name]


def test_memory_can_be_turned_off():
    model = Model()
    place = home(model, remembered=RememberedParams(capacity=0))
    assert [place.ask(ONE)["cached"] for _ in range(2)] == [False, False]
    assert len(model.problems) == 2


def test_many_who_ask_the_same_at_once_pay_once():
    model = Model()
    model.gate.clear()
    place = home(model, budget=Budget(calls_per_hour=1))
    with ThreadPoolExecutor(6) as pool:
        futures = [pool.submit(place.ask, ONE) for _ in range(6)]
        model.gate.set()
        told = [future.result(20.0) for future in futures]
    assert {one["route"] for one in told} == {"reasoned"}
    assert sorted(one["cost"]["vlm_calls"] for one in told) == [0, 0, 0, 0, 0, 1]
    assert sum(one["cached"] for one in told) == 5
    assert {one["instances"][0]["id"] for one in told} == {6}
    assert len(model.problems) == 1
    assert place.bus.counters["verdicts_cached"] + place.bus.counters["verdicts_shared"] == 5


def test_an_answer_that_is_no_candidate_is_not_remembered():
    place = home(lambda request: reply(Verdict(((99, 1.0),), "seen", 1)))
    for _ in range(2):
        answer = place.ask(ONE)
        assert (answer["route"], answer["cached"]) == ("fallback", False)
        assert answer["reason"].startswith("verdict: instance 99 was not a candidate")
        assert answer["cost"]["vlm_calls"] == 1


def adaptive(**changes) -> PolicyParams:
    skill = Skill(mends=1.0, keeps=1.0)
    outlook = OutlookParams(thing=skill, relation=skill, absence=skill)
    return PolicyParams(kind="adaptive", outlook=outlook, **changes)


def test_adaptive_says_why_a_question_is_not_worth_it():
    model = Model()
    dear = adaptive(price=PriceParams(first=1.0))
    place = home(model, policy=dear, budget=Budget(calls_per_hour=10))
    answer = place.ask(ONE)
    assert (answer["route"], model.problems) == ("fast", [])
    assert "; a reasoner would gain 0." in answer["reason"]
    assert "not worth it at a price of 1.00" in answer["reason"]
    assert place.bus.counters["reasoner_not_worth_it"] == 1
    assert spending(place)["price"] == pytest.approx(1.0, abs=0.01)
    assert place.ask(ONE, mode="reason")["route"] == "reasoned"  # the asker insists


def test_adaptive_raises_the_price_with_every_call():
    cheap = adaptive(price=PriceParams(first=0.0))
    place = home(policy=cheap, budget=Budget(calls_per_hour=2))
    assert place.ask(ONE)["route"] == "reasoned"
    assert spending(place)["price"] == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize(("kind", "routes"), [("never", "fast"), ("always", "reasoned")])
def test_the_ends_of_the_scale(kind, routes):
    place = home(policy=PolicyParams(kind=kind))
    assert {place.ask(q)["route"] for q in (ONE, "lamp")} == {routes}
