"""From the front door to a model and back: pictures, deadline, price, and every way to fail."""

import json
import math

import pytest

from sceneq_core.reasoning.reasoner import LabelVerdict, UnansweredError, Usage
from sceneq_core.routing.budget import Budget
from sceneq_core.routing.policy import PolicyParams
from sceneq_core.views.jpeg import jpeg_from_rgb
from sceneq_nodes._asked_reasoner import AskedReasoner
from sceneq_nodes._bus import QueryError, Reply
from sceneq_nodes._front_door import FrontDoor
from sceneq_nodes._look import Look
from sceneq_nodes._purse import Purse
from sceneq_nodes._reason_json import (
    any_problem_from_bytes,
    label_verdict_from_bytes,
    verdict_bytes,
    verdict_from_bytes,
)
from sceneq_nodes.reasoning import Reasoning
from sceneq_schemas.topics import QUERY_ASK, QUERY_LABEL, REASON, VIEW_IMAGE

from support.chat_server import chat_server, chooses, says, sends, waits_then
from support.fake_bus import FakeBus
from support.furnished import router, snapshot
from support.seen_things import keyframe

QUESTION = "pillow on the couch"
PILLOW = 4


class House:
    """Routing's door and a reasoning node with a model on ``url``, each with its own bus."""

    def __init__(self, url, **params):
        chat = {"retries": 0, **params.pop("chat", {})}
        spec = {"kind": "openai", "base_url": url, "model": "m", "chat": chat, **params}
        self.thinking = FakeBus()
        self.thinking.answer(VIEW_IMAGE, self.picture)
        self.node = Reasoning(Reasoning.Params(reasoner=spec), self.thinking.context)
        self.node.open(self.thinking)
        self.routing = FakeBus()
        self.routing.answer(REASON, lambda r: self.thinking.query(REASON, payload=r.payload))
        asked = AskedReasoner(
            self.routing, "room", 5.0, Purse(self.routing, Budget(), PolicyParams())
        )
        look = Look(snapshot(noise=0.0), 0.0)
        door = FrontDoor("room", router(), lambda: look, asked.solve, dict, name=asked.label)
        self.routing.serve(QUERY_ASK, door.ask, scene="room")
        self.routing.serve(QUERY_LABEL, door.label, scene="room")

    def picture(self, request):
        return Reply(jpeg_from_rgb(keyframe(int(request.parameters["seq"]))), "image/jpeg")

    def ask(self, topic=QUERY_ASK, **parameters):
        return json.loads(self.routing.query(topic, parameters=parameters).payload)


@pytest.fixture
def house():
    houses = []

    def make(url, **params):
        houses.append(House(url, **params))
        return houses[-1]

    yield make
    for one in houses:
        one.node.close()


def test_a_question_is_answered_by_the_model_with_its_price(house):
    usage = {"prompt_tokens": 1000, "completion_tokens": 10}
    with chat_server(says('{"choice": "1"}', usage=usage)) as chat:
        home = house(chat.url, prices={"per_million_in": 1.0, "per_million_out": 2.0})
        answer = home.ask(q=QUESTION)
    assert answer["route"] == "reasoned"
    assert answer["instances"][0]["id"] == PILLOW
    assert answer["reason"].startswith(f"m chose instance {PILLOW} in ")
    assert answer["cost"]["vlm_calls"] == 1
    assert answer["cost"]["tokens"] == {"in": 1000, "out": 10}
    assert answer["cost"]["money"] == 0.00102
    assert home.thinking.counters["vlm_calls"] == 1
    assert home.thinking.counters["vlm_tokens"] == 1010
    assert home.thinking.reported["vlm_money"] == 0.00102
    assert {r.topic for r in home.thinking.asked} == {VIEW_IMAGE}


def test_none_of_them_is_reasoned_too(house):
    with chat_server(chooses("none")) as chat:
        answer = house(chat.url).ask(q=QUESTION)
    assert answer["route"] == "reasoned"
    assert answer["status"] == "not_found"  # and the encoder knows pillows well enough to deny
    assert answer["reason"].startswith("m chose none of the boxes in ")


def test_an_instance_is_named_by_the_model_when_asked_to(house):
    with chat_server(chooses("2")) as chat:
        home = house(chat.url)
        fast = home.ask(QUERY_LABEL, id=str(PILLOW))
        answer = home.ask(QUERY_LABEL, id=str(PILLOW), mode="reason", k="3")
    assert (fast["route"], fast["cost"]["vlm_calls"]) == ("fast", 0)
    assert answer["route"] == "reasoned"
    assert answer["labels"][0]["label"] == fast["labels"][1]["label"]
    assert answer["labels"][0]["p"] > 0.6
    assert len(answer["labels"]) == 3
    assert answer["status"] == "found"
    assert answer["reason"] == f"1 of 1 views say '{answer['labels'][0]['label']}' (m)"
    assert answer["cost"]["vlm_calls"] == 1


def nobody(home):
    home.routing.answer(REASON, lambda request: None)


def no_pictures(home):
    def gone(request):
        raise QueryError("not_found", "no image of this keyframe")

    home.thinking.answer(VIEW_IMAGE, gone)


def bad_pictures(home):
    home.thinking.answer(VIEW_IMAGE, lambda request: Reply(b"no JPEG", "image/jpeg"))


TROUBLES = [
    (sends(b"oops", 500), {}, None, "m: HTTP 500: oops", 1),
    (sends(b"slow", 429, retry_after="99"), {"chat": {"retries": 3}}, None, "m: HTTP 429: slow", 1),
    (sends(b"{"), {}, None, "m: the reply is not JSON", 1),
    (chooses("77"), {}, None, "the choice '77' is not in the list", 1),
    (chooses("1"), {"budget": {"calls_per_hour": 0}}, None, "m: the budget is 0 of 0 calls", 0),
    (chooses("1"), {}, no_pictures, "no keyframe to look at", 0),
    (chooses("1"), {}, bad_pictures, "no keyframe to look at", 0),
    (chooses("1"), {}, nobody, "no reasoner answered", 0),
]


@pytest.mark.parametrize(
    ("act", "params", "change", "reason", "calls"), TROUBLES, ids=[row[3] for row in TROUBLES]
)
def test_without_the_model_the_encoder_answers_with_the_reason(
    house, act, params, change, reason, calls
):
    with chat_server(act) as chat:
        home = house(chat.url, **params)
        if change:
            change(home)
        answer = home.ask(q=QUESTION)
        name = home.ask(QUERY_LABEL, id=str(PILLOW), mode="reason")
        fast = home.ask(QUERY_LABEL, id=str(PILLOW))
    assert answer["route"] == name["route"] == "fallback"
    assert answer["reason"].startswith(reason)
    assert answer["instances"][0]["id"] == PILLOW
    assert answer["cost"]["vlm_calls"] == name["cost"]["vlm_calls"] == calls
    assert name["labels"] == fast["labels"]
    assert name["reason"].endswith(fast["reason"])


def test_a_model_that_is_down_costs_nothing(house):
    with chat_server(chooses("1")) as chat:
        url = chat.url
    home = house(url)
    answer = home.ask(q=QUESTION)
    assert answer["route"] == "fallback"
    assert answer["reason"].startswith("m: cannot reach ")
    assert answer["cost"]["vlm_calls"] == 0
    assert home.thinking.counters["problems_unanswered"] == 1
    assert home.routing.counters["reasoner_unanswered"] == 1
    assert "vlm_calls" not in home.thinking.counters


def test_a_slow_model_gives_way_at_the_deadline_of_the_question(house):
    with chat_server(waits_then(chooses("1"))) as chat:
        answer = house(chat.url).ask(q=QUESTION, deadline_ms="1500")
        assert answer["route"] == "fallback"
        assert answer["reason"].startswith("m: no reply in time; ")
        assert answer["cost"]["vlm_calls"] == 1  # it may be on the bill


def test_a_deadline_that_has_passed_asks_nobody(house):
    with chat_server(chooses("1")) as chat:
        home = house(chat.url)
        answer = home.ask(q=QUESTION, deadline_ms="1")
        assert answer["reason"].startswith("no time left for the reasoner; ")
        assert not home.routing.asked
        assert not chat.requests


def test_the_time_of_a_question_goes_along(house):
    with chat_server(chooses("1")) as chat:
        home = house(chat.url)
        home.ask(q=QUESTION)
        home.ask(q=f"the {QUESTION}", deadline_ms="3000")  # the same words would be known
    patient, hurried = (any_problem_from_bytes(r.payload).time_s for r in home.routing.asked)
    assert patient == 5.0
    assert 2.0 < hurried < 3.0


def test_a_long_story_arrives_cut():
    error = UnansweredError("no " * 2000, 3, Usage(7, 0, 0.5))
    with pytest.raises(UnansweredError, match=r"^(no ){333}n$") as caught:
        verdict_from_bytes(verdict_bytes(error))
    assert (caught.value.vlm_calls, caught.value.usage) == (3, Usage(7, 0, 0.5))
    told = label_verdict_from_bytes(verdict_bytes(LabelVerdict((("mug", 1.0),), "x" * 2000, 0)))
    assert told == LabelVerdict((("mug", 1.0),), "x" * 1000, 0)


def test_a_bad_deadline_is_refused(house):
    with pytest.raises(QueryError, match="deadline_ms: 0 is below 1"):
        house("http://127.0.0.1:9/v1").ask(q=QUESTION, deadline_ms="0")


def test_a_bad_label_problem_is_refused(house):
    home = house("http://127.0.0.1:9/v1")
    for payload in (
        b'{"label_of": "x"}',
        b'{"label_of": 3, "labels": [["mug", 2]], "views": []}',
        b'{"label_of": 3, "labels": [[1, 0.2]], "views": []}',
        b'{"label_of": 3, "labels": [], "views": [[1, 2]]}',
        b'{"label_of": 3, "labels": [], "views": [], "time_s": "soon"}',
    ):
        with pytest.raises(QueryError, match="bad_request"):
            home.thinking.query(REASON, payload=payload)
    assert home.thinking.counters["problems_refused"] == 5
    assert math.isinf(any_problem_from_bytes(b'{"label_of":3,"labels":[],"views":[]}').time_s)
