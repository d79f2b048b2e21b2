"""Large replies in pages: any size comes together again, and what does not fit is refused."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_nodes._bus import QueryError, Reply, Request
from sceneq_nodes._fetch import TRIES, Fetch
from sceneq_nodes._pages import FORGOTTEN_S, MOST_WHOLES, Pages
from sceneq_schemas.codec import decode, encode
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.page import PAGE_ENCODING, Page
from sceneq_schemas.topics import VIEW_SNAPSHOT
from sceneq_schemas.view import View, ViewDelta, ViewSet

from support.fake_bus import FakeBus

PAGE_BYTES = 64


def views(count: int, seq: int = 1) -> ViewDelta:
    """Return a message that hardly compresses."""
    rng = np.random.default_rng(seq)
    sets = tuple(
        ViewSet(i + 1, (View(i, i, 5, np.zeros(4, np.float32), (1, 8), rng.bytes(40)),))
        for i in range(count)
    )
    return ViewDelta(1, seq, True, 1, 1, 1, 1, sets)


class Writer:
    """Answers with a message, in pages."""

    def __init__(self, message: ViewDelta | None) -> None:
        self.message = message
        self.now = 0.0
        self.pages = Pages(self.whole, PAGE_BYTES, clock=lambda: self.now)

    def whole(self, request: Request) -> Reply | None:
        if self.message is None:
            return None
        return Reply(encode(self.message), VIEW_SNAPSHOT.encoding)

    def ask(self, **parameters: str) -> Page | None:
        request = Request(VIEW_SNAPSHOT, "key", {}, False, parameters)
        reply = self.pages.answer(request)
        return None if reply is None else decode(Page, reply.payload)


def fetched(bus: FakeBus) -> Fetch:
    fetch = Fetch(bus, VIEW_SNAPSHOT, {}, scene="room")
    while not fetch.done:
        fetch.step()
    return fetch


@settings(max_examples=20, deadline=None)
@given(count=st.integers(0, 40))
def test_any_message_comes_together_again(count: int) -> None:
    bus, message = FakeBus(), views(count)
    bus.answer(VIEW_SNAPSHOT, Writer(message).pages.answer)
    fetch = fetched(bus)
    assert encode(fetch.message) == encode(message)
    assert fetch.received >= 40 * count
    assert {one.parameters["page"] for one in bus.asked} == {str(i) for i in range(len(bus.asked))}


def test_the_pages_belong_to_the_moment_when_the_first_was_asked_for() -> None:
    bus, writer = FakeBus(), Writer(views(20, seq=1))
    bus.answer(VIEW_SNAPSHOT, writer.pages.answer)
    fetch = Fetch(bus, VIEW_SNAPSHOT, {}, scene="room")
    fetch.step()
    writer.message = views(20, seq=2)
    while not fetch.done:
        fetch.step()
    assert fetch.message.seq == 1


def test_nobody_answers_nothing_comes() -> None:
    assert fetched(FakeBus()).message is None


def test_a_writer_without_an_answer_gives_none() -> None:
    bus = FakeBus()
    bus.answer(VIEW_SNAPSHOT, Writer(None).pages.answer)
    assert fetched(bus).message is None


def test_a_writer_that_knows_no_pages_is_understood() -> None:
    bus, message = FakeBus(), views(3)
    bus.answer(VIEW_SNAPSHOT, Writer(message).whole)
    assert encode(fetched(bus).message) == encode(message)


def test_a_lost_page_is_asked_for_again() -> None:
    bus, writer, lost = FakeBus(), Writer(views(20)), iter([False, True, True, False, True])
    bus.answer(VIEW_SNAPSHOT, lambda r: None if next(lost, False) else writer.pages.answer(r))
    assert encode(fetched(bus).message) == encode(writer.message)


def test_a_link_that_stays_cut_ends_the_try() -> None:
    bus, writer = FakeBus(), Writer(views(20))
    bus.answer(
        VIEW_SNAPSHOT, lambda r: writer.pages.answer(r) if r.parameters["page"] == "0" else None
    )
    fetch = Fetch(bus, VIEW_SNAPSHOT, {}, scene="room")
    for _ in range(TRIES):
        fetch.step()
    with pytest.raises(QueryError, match="page 1 did not come"):
        fetch.step()


def test_a_forgotten_whole_is_gone() -> None:
    writer = Writer(views(20))
    first = writer.ask(page="0")
    assert first is not None
    assert writer.ask(page="1", of=first.of) is not None
    writer.now += FORGOTTEN_S + 1
    with pytest.raises(QueryError, match="gone"):
        writer.ask(page="1", of=first.of)


def test_only_the_last_wholes_are_remembered() -> None:
    writer = Writer(None)
    names = []
    for seq in range(MOST_WHOLES + 1):
        writer.message = views(20, seq)
        page = writer.ask(page="0")
        assert page is not None
        names.append(page.of)
    assert writer.ask(page="1", of=names[1]) is not None
    with pytest.raises(QueryError, match="gone"):
        writer.ask(page="1", of=names[0])


@pytest.mark.parametrize("page", ["", "x", "-1", "99", "1" * 9])
def test_a_page_that_is_none_is_refused(page: str) -> None:
    with pytest.raises(QueryError, match="bad_request"):
        Writer(views(3)).ask(page=page)


@pytest.mark.parametrize(
    "harm",
    [
        {"page": 1},
        {"pages": 0},
        {"pages": 5000},
        {"size": 2**40},
        {"size": -1},
        {"size": 7},
        {"digest": "00"},
        {"data": b"no zstd"},
    ],
)
def test_a_page_that_lies_is_refused(harm: dict[str, object]) -> None:
    bus, writer = FakeBus(), Writer(views(1))
    writer.pages = Pages(writer.whole, 1 << 20)
    page = writer.ask(page="0")
    assert page is not None
    lie = encode(replace(page, **harm))  # type: ignore[arg-type]
    bus.answer(VIEW_SNAPSHOT, lambda _: Reply(lie, PAGE_ENCODING))
    with pytest.raises(DecodeError):
        fetched(bus)
