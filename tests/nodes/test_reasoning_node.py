"""The reasoning node: problems in, verdicts out, nonsense refused."""

import json
from dataclasses import replace

import pytest

from sceneq_core.reasoning.reasoner import Problem, Verdict
from sceneq_nodes._bus import QueryError
from sceneq_nodes._params import ParamError
from sceneq_nodes._reason_json import (
    problem_bytes,
    problem_from_bytes,
    verdict_bytes,
    verdict_from_bytes,
)
from sceneq_nodes.reasoning import Reasoning
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.topics import REASON

from support.fake_bus import FakeBus
from support.furnished import router, snapshot


def posed(text: str) -> Problem:
    asked = router()
    problem = asked.answer(snapshot(), asked.read(text)).problem
    assert problem is not None
    return problem


@pytest.fixture
def bus():
    bus = FakeBus()
    Reasoning(Reasoning.Params(), bus.context).open(bus)
    return bus


def test_a_problem_gets_a_verdict(bus):
    reply = bus.query(REASON, payload=problem_bytes(posed("cup on the coffee table")))
    verdict = verdict_from_bytes(reply.payload)
    assert verdict.ranking[0][0] == 6
    assert verdict.reason == "2 cups; instance 6 ('cup') is on instance 5 ('coffee table')"
    assert bus.counters["problems_solved"] == 1


def test_a_get_without_a_problem_is_not_answered(bus):
    assert bus.query(REASON) is None


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda w: w.pop("text"), "text: expected a text"),
        (lambda w: w.update(text="x" * 1001), "at most 1000 characters"),
        (lambda w: w.update(candidates={}), "candidates: expected a list"),
        (lambda w: w.update(candidates=w["candidates"] * 20), "a list of at most 256"),
        (lambda w: w.update(up_world=[0, 0, 0]), "up_world: has no length"),
        (lambda w: w.update(may_spend=0), "may_spend: expected true or false, got 0"),
        (lambda w: w.update(up_world=[0, 1]), "up_world: expected"),
        (lambda w: w.update(viewpoint_world=["a", 0, 0]), "viewpoint_world: expected numbers"),
        (lambda w: w.update(constraints=[["on"]]), r"expected \[relation, anchor\]"),
        (lambda w: w.update(constraints=[["orbiting", "coffee table"]]), "unknown 'orbiting'"),
        (lambda w: w["candidates"][0].update(p=2), "p: 2.0 is not a probability"),
        (lambda w: w["candidates"][0].update(p=True), "p: expected a finite number"),
        (lambda w: w["candidates"][0].update(role="judge"), "neither target nor anchor"),
        (lambda w: w["candidates"][0].update(id=1.5), "id: expected an integer"),
        (lambda w: w["candidates"][0].update(views=[[1, 2]]), "views: expected"),
        (lambda w: w["candidates"].insert(0, 3), "candidate: expected an object"),
    ],
)
def test_bad_problems_are_refused_by_name(bus, change, message):
    wire = json.loads(problem_bytes(posed("cup on the coffee table")))
    change(wire)
    with pytest.raises(QueryError, match=message) as refused:
        bus.query(REASON, payload=json.dumps(wire).encode())
    assert refused.value.code == "bad_request"
    assert bus.counters["problems_refused"] == 1


@pytest.mark.parametrize("payload", [b"{", b"[]", b"\xff\xfe", b"null", b"[" * 100_000])
def test_what_is_not_a_problem_is_refused(bus, payload):
    with pytest.raises(QueryError, match="bad_request"):
        bus.query(REASON, payload=payload)


def test_problems_travel_unchanged():
    problem = posed("red cup next to the lamp")
    back = problem_from_bytes(problem_bytes(problem))
    assert problem_bytes(back) == problem_bytes(problem)
    assert back.constraints == problem.constraints
    assert back.candidates[0].views == problem.candidates[0].views
    assert back.may_spend
    assert not problem_from_bytes(problem_bytes(replace(problem, may_spend=False))).may_spend


def test_verdicts_travel_unchanged():
    verdict = Verdict(((3, 0.75), (1, 0.2)), "because", 2)
    assert verdict_from_bytes(verdict_bytes(verdict)) == verdict


@pytest.mark.parametrize(
    "wire", ['{"ranking": [[1]]}', '{"ranking": [], "reason": 3, "vlm_calls": 0}', "{}", "7"]
)
def test_bad_verdicts_are_refused(wire):
    with pytest.raises(DecodeError):
        verdict_from_bytes(wire.encode())


def test_a_problem_with_nan_cannot_be_sent():
    problem = posed("cup")
    lost = replace(problem, viewpoint_world=problem.viewpoint_world * float("nan"))
    with pytest.raises(ValueError, match="JSON"):
        problem_bytes(lost)


def test_an_unknown_reasoner_is_a_clear_error():
    bus = FakeBus()
    node = Reasoning(Reasoning.Params(reasoner={"kind": "geometri"}), bus.context)
    with pytest.raises(ParamError, match="did you mean 'geometric'"):
        node.open(bus)
