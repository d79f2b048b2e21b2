"""Parameters as zenoh sends them, a pool that refuses instead of growing, errors as JSON."""

import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_nodes._bus import QueryError, Reply, Request
from sceneq_nodes._queries import (
    QueryPool,
    answer,
    error_bytes,
    error_from_bytes,
    format_parameters,
    parse_parameters,
)
from sceneq_schemas.topics import QUERY_STATUS

REQUEST = Request(QUERY_STATUS, QUERY_STATUS.key(scene="room"), {"scene": "room"}, False)


@pytest.mark.parametrize(
    ("text", "parameters"),
    [
        ("", {}),
        ("q=red mug", {"q": "red mug"}),
        ("q=red%20mug;k=5", {"q": "red mug", "k": "5"}),
        ("q=50% wool", {"q": "50% wool"}),
        ("q=a%3Bb", {"q": "a;b"}),
        ("q=1=2;flag;;q=late", {"q": "1=2", "flag": ""}),
        ("q=Becher & Löffel+x", {"q": "Becher & Löffel+x"}),
        ("q=%C3%BC", {"q": "ü"}),
        ("q=%FF", {"q": "\ufffd"}),
    ],
)
def test_parameters(text: str, parameters: dict[str, str]) -> None:
    assert parse_parameters(text) == parameters


@given(st.dictionaries(st.text(min_size=1), st.text(), max_size=4))
def test_parameters_come_back(parameters: dict[str, str]) -> None:
    assert parse_parameters(format_parameters(parameters)) == parameters


def test_plain_text_stays_readable_in_the_selector() -> None:
    assert (
        format_parameters({"q": "red mug, left of it?", "k": "5"}) == "q=red mug, left of it?;k=5"
    )


@pytest.mark.parametrize("retry_ms", [None, 200])
def test_errors_come_back(retry_ms: int | None) -> None:
    again = error_from_bytes(error_bytes(QueryError("busy", "full", "wait", retry_ms)))
    assert (again.code, again.message, again.hint, again.retry_ms) == (
        "busy", "full", "wait", retry_ms,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("payload", "code"),
    [(b"Timeout", "timeout"), (b"", "unknown"), (b"[1]", "unknown"), (b"{}", "unknown"),
     (b"\xff" * 300, "unknown"), (b"[" * 100_000, "unknown")],
)  # fmt: skip
def test_errors_of_others_are_told_as_they_are(payload: bytes, code: str) -> None:
    error = error_from_bytes(payload)
    assert error.code == code
    assert len(error.message) <= 200


def test_what_a_handler_says_is_the_answer() -> None:
    reply = Reply(b"{}", "application/json")
    refusal = QueryError("bad_request", "no question")

    def refuse(_: Request) -> Reply:
        raise refusal

    assert answer(lambda _: reply, REQUEST) is reply
    assert answer(lambda _: None, REQUEST) is None
    assert answer(refuse, REQUEST) is refusal


def test_a_bug_in_a_handler_is_internal_and_logged(caplog: pytest.LogCaptureFixture) -> None:
    def broken(_: Request) -> Reply:
        raise KeyError("mug")

    error = answer(broken, REQUEST)
    assert isinstance(error, QueryError)
    assert (error.code, error.message) == ("internal", "KeyError: 'mug'")
    assert "query on sceneq/query/room/status failed" in caplog.text
    assert "Traceback" in caplog.text


def test_a_reply_that_is_too_large_is_an_error() -> None:
    error = answer(lambda _: Reply(b"x" * (QUERY_STATUS.max_bytes + 1), ""), REQUEST)
    assert isinstance(error, QueryError)
    assert error.code == "too_large"


def test_the_pool_refuses_what_it_cannot_hold_and_recovers() -> None:
    pool = QueryPool(workers=1, slots=2)
    gate, done = threading.Event(), threading.Semaphore(0)

    def wait() -> None:
        gate.wait()
        done.release()

    pool.submit(wait)
    pool.submit(wait)
    with pytest.raises(QueryError, match="busy") as caught:
        pool.submit(wait)
    assert caught.value.retry_ms == 200
    gate.set()
    assert done.acquire(timeout=30)
    assert done.acquire(timeout=30)
    pool_is_free_again(pool)


def pool_is_free_again(pool: QueryPool) -> None:
    """A slot comes back a moment after its job; two jobs at once need both."""
    for _ in range(3_000):
        try:
            ran = threading.Event()
            pool.submit(ran.set)
        except QueryError:
            threading.Event().wait(0.01)
        else:
            assert ran.wait(30)
            return
    raise AssertionError("no slot came back")


def test_a_job_that_fails_does_not_take_its_thread_along(caplog: pytest.LogCaptureFixture) -> None:
    pool = QueryPool(workers=1, slots=4)

    def fail() -> None:
        raise RuntimeError("the session is closed")

    ran = threading.Event()
    pool.submit(fail)
    pool.submit(ran.set)
    assert ran.wait(30)
    assert "a query could not be answered" in caplog.text
