"""What a client does while a scene is busy or away, and how answers become values."""

import json
from collections.abc import Iterator
from typing import Any

import pytest

from sceneq_client import (
    Answer,
    BusyError,
    Change,
    Instance,
    NoAnswerError,
    RefusedError,
    SceneError,
    Subscription,
)
from sceneq_client.asking import put
from sceneq_client.changes import MapEvents
from sceneq_client.standing import Sighting, StandingQuestion
from sceneq_core.mapping.delta import Event
from sceneq_nodes._bus import QueryError, Reply
from sceneq_nodes._convert import map_delta_message
from sceneq_nodes._wire import to_bytes
from sceneq_schemas.topics import MAP_DELTA, QUERY_ASK

from support.true_map import delta

INSTANCE = {
    "id": 7, "label": "mug", "p": 0.9, "state": "confirmed", "role": "object",
    "centre": [1, 2, 3], "box_aabb": {"min": [0.9, 1.9, 2.9], "max": [1.1, 2.1, 3.2]},
    "first_seen_ns": 5, "last_seen_ns": 9,
    "views": [{"seq": 3, "box_xyxy": [1, 2, 3, 4], "key": "sceneq/view/room/@image/v1?seq=3"}],
}  # fmt: skip
ANSWER = {
    "status": "found", "question": "mug", "said": "The mug (7).", "instances": [INSTANCE],
    "confidence": {"p_max": 0.9, "margin": 0.5, "entropy_norm": 0.1, "T": 1.0},
    "route": "fast", "reason": "", "newer": 1,
}  # fmt: skip


class Scripted:
    """Answers one result after the other, the last one for ever."""

    def __init__(self, *results: Any) -> None:
        self.results = list(results)
        self.asked: list[dict[str, Any]] = []

    def get(self, selector: str, payload: bytes, encoding: str, timeout_s: float) -> Any:
        assert selector == "sceneq/query/room/ask"
        self.asked.append(json.loads(payload))
        return self.results.pop(0) if len(self.results) > 1 else self.results[0]


def told(value: Any) -> Any:
    return [("key", Reply(json.dumps(value).encode(), ""))], []


def refused(code: str, retry_ms: int | None = None) -> Any:
    return [], [QueryError(code, "because", "do this", retry_ms)]


def asked(scripted: Scripted, timeout_s: float = 5.0, absent_s: float = 1.0) -> dict[str, Any]:
    return put(scripted, QUERY_ASK, "room", {"q": "mug"}, timeout_s, absent_s)  # type: ignore[arg-type]


def test_a_busy_or_restarting_scene_is_asked_again() -> None:
    scripted = Scripted(refused("busy", 1), ([], []), told({"status": "found"}))
    assert asked(scripted) == {"status": "found"}
    assert scripted.asked == [{"q": "mug"}] * 3


@pytest.mark.parametrize(
    ("result", "error", "message"),
    [
        (([], []), NoAnswerError, "nobody answers for scene 'room'"),
        (refused("busy", 9000), BusyError, "busy: because"),
        (refused("timeout"), NoAnswerError, "did not answer within 5 s"),
        (refused("bad_request"), RefusedError, r"bad_request: because \(do this\)"),
        (([("key", Reply(b"{", ""))], []), SceneError, "not JSON"),
        (told([1]), SceneError, "not a JSON object"),
    ],
)
def test_no_answer_is_an_error_that_says_why(
    result: Any, error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        asked(Scripted(result), absent_s=0.0)


def test_an_answer_is_typed_and_keeps_what_it_does_not_know() -> None:
    answer = Answer.read(ANSWER)
    assert answer.found
    assert answer.best is not None
    assert answer.best.box.size_m == pytest.approx((0.2, 0.2, 0.3))
    assert answer.best.views[0].box_xyxy == (1, 2, 3, 4)
    assert answer.raw["newer"] == 1
    assert Answer.read({**ANSWER, "status": "not_found"}).best is None
    with pytest.raises(KeyError):
        Answer.read({"status": "found"})


def test_a_slow_reader_loses_the_oldest_and_can_see_it() -> None:
    subscription: Subscription[int] = Subscription()
    for number in range(1003):
        subscription.put(number)
    assert subscription.lost == 3
    assert subscription.get(0) == 3
    subscription.close()
    assert list(subscription) == list(range(4, 1003))
    assert subscription.get(0) is None
    subscription.put(5)
    assert list(subscription) == []


def test_ends_are_called_once() -> None:
    ended: list[str] = []
    with Subscription[int]() as subscription:
        subscription.on_close(lambda: ended.append("a"))
        subscription.on_close(lambda: ended.append("b"))
    subscription.close()
    assert ended == ["a", "b"]


def events_of(kinds: tuple[str, ...]) -> tuple[Event, ...]:
    return tuple(Event(kind, 7, 0, 4) for kind in kinds)


def test_events_of_the_map_are_changes_and_a_hole_between_them_is_one() -> None:
    changes: list[Change] = []
    events = MapEvents(changes.append)

    def hear(epoch: int, seq: int, *kinds: str) -> None:
        message = map_delta_message(delta(events=events_of(kinds)), epoch, seq)
        events.hear("key", "", to_bytes(MAP_DELTA, message))

    hear(8, 3, "appeared")
    hear(8, 4, "moved", "merged")
    hear(8, 6, "removed")
    hear(9, 1)
    assert [change.kind for change in changes] == [
        "appeared", "moved", "merged", "gap", "removed", "gap",
    ]  # fmt: skip
    events.hear("key", "", b"nonsense")
    assert events.undecodable == 1


class Scene:
    """Answers a standing question with the ids of the next look, or not at all."""

    def __init__(self, *looks: dict[int, float] | None) -> None:
        self._looks: Iterator[dict[int, float] | None] = iter(looks)
        self.told: Subscription[Sighting] = Subscription()
        self.standing = StandingQuestion("mug", self._ask, self.told.put, 0.0, 0.5)

    def _ask(self, question: str) -> Answer:
        look = next(self._looks, {})
        if look is None:
            raise NoAnswerError("away")
        there = [{**INSTANCE, "id": number, "p": p} for number, p in look.items()]
        status = "found" if there else "not_found"
        return Answer.read({**ANSWER, "status": status, "question": question, "instances": there})

    def next_id(self) -> int:
        sighting = self.told.get(5)
        assert sighting is not None
        assert isinstance(sighting.instance, Instance)
        return sighting.instance.id


def test_a_standing_question_tells_each_thing_once_while_it_stays() -> None:
    scene = Scene({7: 0.9, 8: 0.2}, {7: 0.9, 8: 0.6}, {8: 0.6}, None, {8: 0.6, 7: 0.8})
    scene.standing.start()
    assert scene.next_id() == 7
    scene.standing.changed()
    assert scene.next_id() == 8
    scene.standing.changed()
    while scene.standing.unanswered == 0:  # asked again by itself after no answer
        scene.standing.changed()
    assert scene.next_id() == 7
    scene.standing.close()
    assert scene.told.get(0) is None
