"""The bus inside one process."""

from typing import Any, ClassVar

import pytest

from sceneq_nodes._bus import Context, QueryError, Received, Reply, Request
from sceneq_schemas.topics import MASK, QUERY_STATUS
from sceneq_tools.local_bus import LocalBus, LocalHub

from support.room import Room

CONTEXT = {"scene": "s", "robot": "r", "sensor": "c"}


class Talker:
    """Publishes its turn number when idle."""

    Params: ClassVar[type] = object
    idle_s: ClassVar[float] = 0.0

    def __init__(self, name: str, listens_to: str) -> None:
        self.name, self.listens_to = name, listens_to
        self.heard: list[Any] = []

    def open(self, bus: LocalBus) -> None:
        self.bus = bus
        bus.subscribe(MASK, depth=1, scene=self.listens_to)
        bus.serve(QUERY_STATUS, self.answer, scene=self.name)

    def step(self, received: Received | None) -> None:
        if received is None:
            self.bus.publish(MASK, 1, scene=self.name)
            self.bus.publish(MASK, 2, scene=self.name)
        else:
            self.heard.append(received.message)

    def answer(self, request: Request) -> Reply:
        if "q" in request.parameters:
            raise QueryError("bad_request", "no q here")
        return Reply(b"fine", "text/plain")

    def close(self) -> None:
        self.bus.count("closed")


def hub_with(*nodes: Talker) -> LocalHub:
    hub = LocalHub()
    for node in nodes:
        hub.add(node, Context(node.name, **CONTEXT))  # type: ignore[arg-type]
    return hub


def test_messages_reach_exactly_their_listeners_in_order_and_none_is_lost() -> None:
    a, b = Talker("a", listens_to="b"), Talker("b", listens_to="a")
    hub = hub_with(a, b)
    for _ in range(100):
        hub.idle("a")
    assert (a.heard, b.heard) == ([], [1, 2] * 100)


def test_questions_are_answered_by_the_one_who_serves_the_key() -> None:
    a, b = Talker("a", "b"), Talker("b", "a")
    hub_with(a, b)
    assert [reply.payload for reply in a.bus.ask(QUERY_STATUS, scene="b")] == [b"fine"]
    assert a.bus.ask(QUERY_STATUS, scene="nobody") == []
    with pytest.raises(QueryError, match="no q here"):
        a.bus.ask(QUERY_STATUS, parameters={"q": "x"}, scene="b")
    assert a.bus.alive() == {"a", "b"}


def test_reports_are_kept_per_node_and_counters_together() -> None:
    a, b = Talker("a", "b"), Talker("b", "a")
    hub = hub_with(a, b)
    a.bus.report(state="x", n=1)
    a.bus.report(n=2)
    hub.close()
    assert hub.reported == {"a": {"state": "x", "n": 2}, "b": {}}
    assert hub.counters == {"closed": 2}


def test_the_room_of_the_tests_is_metric() -> None:
    rgb, depth_mm, instance, T_world_camera = Room().frame(2, 5)
    centre = depth_mm[60, 80] / 1000 * T_world_camera[:3, 2] + T_world_camera[:3, 3]
    assert rgb.shape == (120, 160, 3)
    assert instance[60, 80] == 3
    assert centre[1] == pytest.approx(1.0 - 0.35, abs=0.05)
