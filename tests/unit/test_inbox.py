"""Newest kept, loss seen, arrival order between topics, no waiting when there is something."""

import threading

import pytest

from sceneq_nodes._counters import Counters
from sceneq_nodes._inbox import Inbox, Raw
from sceneq_schemas.topics import FRAME, POSE


def raw(number: int) -> Raw:
    return Raw(POSE, "sceneq/pose/r1/v1", bytes([number]))


def taken(inbox: Inbox) -> list[int]:
    numbers = []
    while (message := inbox.take(0.0)) is not None:
        numbers.append(message.data[0])
    return numbers


def test_the_oldest_goes_when_it_is_full() -> None:
    inbox = Inbox()
    inbox.open("a", 2)
    assert [inbox.put("a", raw(n)) for n in range(4)] == [True, True, False, False]
    assert inbox.depths() == {"a": 2}
    assert taken(inbox) == [2, 3]


def test_topics_do_not_push_each_other_out_and_keep_their_order() -> None:
    inbox = Inbox()
    inbox.open("frames", 1)
    inbox.open("poses", 3)
    for selector, number in [("poses", 1), ("frames", 2), ("poses", 3), ("frames", 4)]:
        inbox.put(selector, raw(number))
    assert taken(inbox) == [1, 3, 4]


def test_nothing_comes_from_an_empty_inbox() -> None:
    inbox = Inbox()
    assert inbox.take(0.0) is None
    inbox.open("a", 1)
    assert inbox.take(0.01) is None


def test_a_message_wakes_the_reader() -> None:
    inbox = Inbox()
    inbox.open("a", 1)
    threading.Timer(0.05, inbox.put, ("a", raw(5))).start()
    message = inbox.take(30.0)
    assert message is not None
    assert message.data == b"\x05"


def test_a_queue_holds_something() -> None:
    with pytest.raises(ValueError, match="a: depth 0 must be at least 1"):
        Inbox().open("a", 0)


def test_many_writers_lose_nothing_but_what_is_counted() -> None:
    inbox = Inbox()
    inbox.open("a", 16)
    kept: list[bool] = []
    threads = [
        threading.Thread(target=lambda: kept.extend(inbox.put("a", raw(n)) for n in range(200)))
        for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(kept) == 800
    assert kept.count(True) == 16
    assert len(taken(inbox)) == 16


def test_counters_say_what_happened_and_how_long_ago() -> None:
    now = [10.0]
    counters = Counters(clock=lambda: now[0])
    counters.topic(FRAME.name, "in")
    counters.topic(FRAME.name, "in")
    counters.topic(POSE.name, "dropped")
    assert counters.topic(POSE.name, "dropped") == 2
    assert counters.count("skipped", 3) == 3
    counters.report(instances=12, source="folder")
    counters.report(instances=13)
    now[0] = 12.5
    assert counters.snapshot() == {
        "topics": {
            "frame": {"in": 2, "age_ms": 2500},
            "pose": {"dropped": 2, "age_ms": None},
        },
        "counters": {"skipped": 3},
        "values": {"instances": 13, "source": "folder"},
    }
