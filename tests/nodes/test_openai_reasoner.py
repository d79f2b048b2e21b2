"""The reasoner behind a chat server: what is asked, and what becomes of every kind of trouble."""

import base64
import logging
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest

from sceneq_core.reasoning.reasoner import UnansweredError
from sceneq_core.views.jpeg import rgb_from_jpeg
from sceneq_nodes._backends import build
from sceneq_nodes._params import ParamError

from support.chat_reasoner import reasoners, unanswered
from support.chat_server import (
    chat_server,
    chooses,
    says,
    sends,
    waits_then,
)
from support.seen_things import MUGS, keyframe, thing, what_is_it, which_mug

KEY = "sk-very-secret-4711"


@pytest.fixture
def reasoner():
    with reasoners() as make:
        yield make


# what is asked


def test_candidates_are_numbered_boxes_over_as_few_full_views_as_cover_them(reasoner):
    with chat_server(chooses("2")) as chat:
        verdict = reasoner(chat.url).solve(which_mug(), keyframe)
    assert verdict.ranking[0][0] == 4
    assert chat.paths == ["/v1/chat/completions"]
    assert len(chat.images()) == 2  # keyframe 3 shows two of the three, 8 the third
    assert "box 1 at [10, 20, 40, 60]; box 2 at [110, 20, 150, 60]" in chat.asked()
    assert "Picture 2 (160 x 120): box 3 at [60, 20, 90, 60]" in chat.asked()
    assert '"the mug next to the sink"' in chat.asked()
    kind, _, data = chat.images()[0].partition(",")
    assert kind == "data:image/jpeg;base64"
    picture = rgb_from_jpeg(base64.b64decode(data))
    assert picture.shape == (120, 160, 3)
    assert abs(int(picture[90, 80, 0]) - 103) < 3  # the full view of keyframe 3, ...
    assert picture[19:22, 12:38].std() > 20  # ... with the outline of box 1 on it


def test_a_structured_reply_is_asked_for_with_the_choices_enumerated(reasoner):
    with chat_server(chooses("1")) as chat:
        reasoner(chat.url).solve(which_mug(), keyframe)
    form = chat.requests[0]["response_format"]
    assert form["type"] == "json_schema"
    assert form["json_schema"]["schema"]["properties"]["choice"]["enum"] == ["1", "2", "3", "none"]
    assert chat.requests[0]["model"] == "m"
    assert chat.requests[0]["temperature"] == 0


def test_an_instance_is_named_by_one_call_a_view_and_the_majority(reasoner):
    with chat_server(chooses("2"), chooses("1"), chooses("2")) as chat:
        verdict = reasoner(chat.url).label(what_is_it(), keyframe)
    assert len(chat.requests) == verdict.vlm_calls == 3
    assert all(len(chat.images(i)) == 1 for i in range(3))
    assert "box 1 at [10, 20, 40, 60]" in chat.asked(0)
    assert '1: "mug", 2: "cup", 3: "bowl"' in chat.asked(0)
    assert [name for name, _ in verdict.ranking] == ["cup", "mug", "bowl"]
    assert verdict.reason == "2 of 3 views say 'cup' (m)"


def test_a_tie_goes_to_the_encoders_first(reasoner):
    with chat_server(chooses("3"), chooses("1")) as chat:
        verdict = reasoner(chat.url).label(what_is_it(seqs=(3, 5)), keyframe)
    assert [name for name, _ in verdict.ranking] == ["mug", "bowl", "cup"]


def test_none_of_these_is_an_answer(reasoner):
    with chat_server(chooses("none")) as chat:
        verdict = reasoner(chat.url).solve(which_mug(), keyframe)
    assert verdict.ranking == ()
    assert verdict.reason == "m chose none of the boxes in 2 pictures"


def test_keyframes_that_are_gone_are_replaced_by_others(reasoner):
    with chat_server(chooses("1")) as chat:
        verdict = reasoner(chat.url).solve(
            which_mug(), lambda seq, _: None if seq == 3 else keyframe(seq)
        )
    assert verdict.ranking[0][0] == 7  # seen in keyframe 5 as well
    assert "1 of 3 candidates could not be shown" in verdict.reason


def test_without_any_picture_nothing_is_asked(reasoner):
    with chat_server(chooses("1")) as chat:
        error = unanswered(reasoner(chat.url), pictures=lambda seq, timeout_s: None)
    assert str(error) == "no keyframe to look at"
    assert not chat.requests


def test_without_candidates_nothing_is_asked(reasoner):
    with chat_server(chooses("1")) as chat:
        verdict = reasoner(chat.url).solve(which_mug(candidates=()), keyframe)
    assert (verdict.ranking, verdict.vlm_calls, chat.requests) == ((), 0, [])


def test_keys_of_the_request_can_be_set_and_left_out(reasoner):
    with chat_server(chooses("1")) as chat:
        body = {"max_tokens": None, "max_completion_tokens": 40}
        reasoner(chat.url, chat={"body": body}).solve(which_mug(), keyframe)
    assert "max_tokens" not in chat.requests[0]
    assert chat.requests[0]["max_completion_tokens"] == 40


# the key


def test_the_key_comes_from_the_environment_and_is_never_told(reasoner, monkeypatch, caplog):
    monkeypatch.setenv("SCENE_KEY", KEY)
    caplog.set_level(logging.DEBUG)
    with chat_server(says(f"wrong key {KEY}", 401)) as chat:
        built = reasoner(chat.url, key_env="SCENE_KEY")
        error = unanswered(built)
    assert chat.headers[0]["Authorization"] == f"Bearer {KEY}"
    assert str(error).startswith("m: HTTP 401: ")
    assert "wrong key ***" in str(error)
    assert KEY not in caplog.text
    assert KEY not in str(vars(built))


def test_without_a_key_none_is_sent(reasoner):
    with chat_server(chooses("1")) as chat:
        reasoner(chat.url).solve(which_mug(), keyframe)
    assert "Authorization" not in chat.headers[0]


@pytest.mark.parametrize(("value", "message"), [(None, "is not set"), ("a b", "odd characters")])
def test_what_cannot_be_a_key_is_refused_without_saying_it(reasoner, monkeypatch, value, message):
    monkeypatch.delenv("SCENE_KEY", raising=False)
    if value:
        monkeypatch.setenv("SCENE_KEY", value)
    with pytest.raises(ValueError, match=f"key_env: .*SCENE_KEY.*{message}") as caught:
        reasoner("http://127.0.0.1:9/v1", key_env="SCENE_KEY")
    assert "a b" not in str(caught.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"base_url": "ftp://x/v1"}, "base_url"),
        ({"base_url": "http:///v1"}, "base_url"),
        ({"base_url": "http://host:99999/v1"}, "Port out of range"),
        ({"base_url": "http://:key@host/v1"}, "key belongs into the environment"),
        ({"model": ""}, "model"),
        ({"concurrency": 0}, "concurrency"),
        ({"chat": {"retries": 99}}, "retries"),
        ({"visual": {"prior_votes": 1.0}}, "prior_votes"),
        ({"budget": {"calls_per_hour": -1}}, "calls_per_hour"),
        ({"prices": {"per_call": -0.1}}, "per_call"),
        ({"breaker": {"failures": 0}}, "failures"),
    ],
)
def test_parameters_are_checked(change, message):
    spec = {"kind": "openai", "base_url": "http://127.0.0.1:9/v1", "model": "m"} | change
    with pytest.raises(ParamError, match=message):
        build("reasoner", spec)


# the same question is paid once


def test_a_question_that_was_answered_is_remembered(reasoner):
    with chat_server(chooses("2"), chooses("3")) as chat:
        built = reasoner(chat.url)
        first, again = (built.solve(which_mug(), keyframe) for _ in range(2))
        other = built.solve(which_mug("another"), keyframe)
    assert first.ranking == again.ranking
    assert (first.vlm_calls, again.vlm_calls, again.usage.tokens_in) == (1, 0, 0)
    assert other.vlm_calls == 1


def test_other_pictures_are_another_question(reasoner):
    with chat_server(chooses("2"), chooses("3")) as chat:
        built = reasoner(chat.url)
        built.solve(which_mug(), keyframe)
        changed = built.solve(which_mug(), lambda seq, timeout_s: keyframe(seq + 1))
    assert (changed.ranking[0][0], changed.vlm_calls) == (9, 1)


def test_a_reply_that_could_not_be_used_is_not_remembered(reasoner):
    with chat_server(says("hm"), chooses("3")) as chat:
        built = reasoner(chat.url)
        unanswered(built)
        assert built.solve(which_mug(), keyframe).ranking[0][0] == 9


def test_nothing_is_remembered_when_told_so(reasoner):
    with chat_server(chooses("2")) as chat:
        built = reasoner(chat.url, remembered=0)
        assert [built.solve(which_mug(), keyframe).vlm_calls for _ in range(2)] == [1, 1]


def test_the_same_question_asked_by_several_at_once_is_one_call(reasoner):
    with chat_server(waits_then(chooses("2"))) as chat, ThreadPoolExecutor(4) as people:
        built = reasoner(chat.url)
        asked = [people.submit(built.solve, which_mug(time_s=30.0), keyframe) for _ in range(4)]
        while not chat.requests:
            time.sleep(0.01)
        chat.released.set()
        verdicts = [one.result() for one in asked]
    assert len(chat.requests) == 1
    assert {verdict.ranking[0][0] for verdict in verdicts} == {4}
    assert sum(verdict.vlm_calls for verdict in verdicts) == 1


def test_who_shares_a_call_that_runs_out_of_time_asks_again(reasoner):
    with chat_server(waits_then(chooses("2")), chooses("3")) as chat, ThreadPoolExecutor(1) as one:
        built = reasoner(chat.url)
        hurried = one.submit(built.solve, which_mug(time_s=1.5), keyframe)
        while not chat.requests:
            time.sleep(0.01)
        patient = built.solve(which_mug(time_s=30.0), keyframe)
        assert patient.ranking[0][0] == 9
        with pytest.raises(UnansweredError, match="no reply in time"):
            hurried.result()


# breaker, budget, accounting


def test_a_server_that_keeps_failing_is_left_alone_for_a_while(reasoner):
    with chat_server(sends(b"oops", 500)) as chat:
        built = reasoner(chat.url, chat={"retries": 0}, breaker={"failures": 2, "rest_s": 60})
        unanswered(built)
        unanswered(built)
        error = unanswered(built)
    assert str(error) == ("m: 2 failures in a row, the last: HTTP 500: oops; asked again in 60 s")
    assert error.vlm_calls == 0
    assert len(chat.requests) == 2


def test_tokens_and_money_are_counted(reasoner):
    prices = {"per_million_in": 2.0, "per_million_out": 10.0, "per_call": 0.01}
    usage = {"prompt_tokens": 1000, "completion_tokens": 20}
    with chat_server(says('{"choice": "1"}', usage=usage)) as chat:
        verdict = reasoner(chat.url, prices=prices).label(what_is_it(), keyframe)
    assert verdict.vlm_calls == 3
    assert (verdict.usage.tokens_in, verdict.usage.tokens_out) == (3000, 60)
    assert verdict.usage.money == pytest.approx(3 * (0.01 + 0.002 + 0.0002))


def test_tokens_that_a_server_does_not_count_are_estimated(reasoner):
    with chat_server(says('{"choice": "1"}', usage={})) as chat:
        verdict = reasoner(chat.url).solve(which_mug(), keyframe)
    pixels = 2 * 120 * 160
    assert pixels // 784 < verdict.usage.tokens_in < pixels // 784 + 400
    assert verdict.usage.tokens_out == 4


@pytest.mark.parametrize(
    ("budget", "why"),
    [
        ({"calls_per_hour": 1}, "1 of 1 calls"),
        ({"tokens_per_hour": 500}, "908 of 500 tokens"),
        ({"money_per_hour": 0.0005}, "0.000908 of 0.0005 money"),
    ],
)
def test_a_spent_budget_refuses_further_calls(reasoner, budget, why):
    prices = {"per_million_in": 1.0, "per_million_out": 1.0}
    with chat_server(chooses("1")) as chat:
        built = reasoner(chat.url, budget=budget, prices=prices)
        built.solve(which_mug(), keyframe)
        error = unanswered(built, which_mug("another"))
    assert str(error).startswith(f"m: the hour's budget is spent: {why}; the oldest call leaves it")
    assert len(chat.requests) == 1


def test_a_spent_budget_does_not_open_the_circuit(reasoner):
    with chat_server(chooses("1")) as chat:
        built = reasoner(chat.url, budget={"calls_per_hour": 0}, breaker={"failures": 1})
        unanswered(built)
        assert str(unanswered(built)) == "m: the budget is 0 of 0 calls an hour"
    assert not chat.requests


def test_no_more_calls_than_allowed_are_under_way(reasoner):
    with chat_server(waits_then(chooses("1"))) as chat:
        built = reasoner(chat.url, concurrency=2)
        with pytest.raises(UnansweredError, match="no reply in time"):
            built.label(what_is_it(time_s=1.5), keyframe)
        assert len(chat.requests) == 2


def test_a_question_without_time_left_is_not_asked(reasoner):
    with chat_server(chooses("1")) as chat:
        error = unanswered(reasoner(chat.url), which_mug(time_s=0.0))
    assert not chat.requests
    assert (str(error), error.vlm_calls) == ("no time left to look", 0)


def test_many_candidates_are_shown_in_few_pictures(reasoner):
    crowd = tuple(thing(i, 0.02, (i % 3, (10.0 * i, 5.0, 10.0 * i + 9, 50.0))) for i in range(12))
    with chat_server(chooses("12")) as chat:
        built = reasoner(chat.url, visual={"max_views": 2})
        error = unanswered(built, which_mug(candidates=crowd))
    assert str(error) == "the choice '12' is not in the list"  # 8 of 12 fit into two pictures
    assert len(chat.images()) == 2
    assert len(MUGS) < 8


def test_without_leave_to_spend_nothing_is_sent(reasoner):
    with chat_server(chooses("2")) as chat:
        asked = reasoner(chat.url)
        for ask, problem in ((asked.solve, which_mug()), (asked.label, what_is_it())):
            with pytest.raises(UnansweredError, match="a call of a model is not allowed now"):
                ask(replace(problem, may_spend=False), keyframe)
        assert not chat.requests
        assert asked.solve(which_mug(), keyframe).vlm_calls == 1
