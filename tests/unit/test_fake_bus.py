"""The bus of the node tests behaves like the real one where a node could tell the difference."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_nodes._bus import QueryError, Reply
from sceneq_schemas.frame import Pose
from sceneq_schemas.topics import FRAME, HEALTH, POSE, QUERY_INSTANCES, QUERY_STATUS

from support.fake_bus import CONTEXT, FakeBus, FakeHub
from support.messages import same
from support.toy_node import Toy, ToyParams

POSE_7 = Pose(7, 7, np.eye(4), "given", False)


@pytest.fixture
def bus() -> FakeBus:
    return FakeBus()


@pytest.fixture
def toy(bus: FakeBus) -> Toy:
    toy = Toy(ToyParams(), bus.context)
    toy.open(bus)
    return toy


def test_a_delivered_message_reaches_step_and_the_answer_is_recorded(
    bus: FakeBus, toy: Toy
) -> None:
    bus.deliver(toy, POSE, POSE_7)
    topic, ids, message = bus.published[-1]
    assert (topic, ids) == (POSE, {"robot": "echo"})
    assert same(message, POSE_7)
    assert bus.sent(POSE) == [message]
    assert bus.reported == {"seq": 7}
    assert bus.subscriptions == {"sceneq/pose/r1/v1": 4}


def test_what_nobody_subscribed_to_cannot_be_delivered(bus: FakeBus, toy: Toy) -> None:
    with pytest.raises(AssertionError, match="nothing subscribed to sceneq/pose/r2/v1"):
        bus.deliver(toy, POSE, POSE_7, robot="r2")


def test_messages_go_through_the_codec(bus: FakeBus) -> None:
    with pytest.raises(ValueError, match=r"Pose.T_world_camera: expected <f8\[4, 4\]"):
        bus.publish(POSE, replace(POSE_7, T_world_camera=np.eye(3)), robot="r1")
    with pytest.raises(ValueError, match="frame: expected Frame, got Pose"):
        bus.publish(FRAME, POSE_7, robot="r1", sensor="cam")
    with pytest.raises(ValueError, match="pose: expected the ids robot, got scene"):
        bus.publish(POSE, POSE_7, scene="room")
    with pytest.raises(ValueError, match="JSON"):
        bus.publish(HEALTH, {"x": float("nan")}, node="test")
    with pytest.raises(ValueError, match="the limit is 4096"):
        bus.publish(POSE, replace(POSE_7, source="x" * 5000), robot="r1")
    assert bus.published == []


def test_queries_reach_the_handler(bus: FakeBus, toy: Toy) -> None:
    reply = bus.query(QUERY_INSTANCES, parameters={"q": "mug"}, wildcard=True)
    assert reply is not None
    assert b'"wildcard": true' in reply.payload
    assert bus.query(QUERY_INSTANCES, parameters={"do": "nothing"}) is None
    with pytest.raises(QueryError, match="bad_request: no question"):
        bus.query(QUERY_INSTANCES, parameters={"do": "refuse"})


def test_answers_to_ask_are_scripted(bus: FakeBus) -> None:
    assert bus.ask(QUERY_STATUS, scene="room") == []
    bus.answer(QUERY_STATUS, lambda request: Reply(request.parameters["q"].encode(), "text/plain"))
    replies = bus.ask(QUERY_STATUS, parameters={"q": "mug"}, scene="room")
    assert replies == [Reply(b"mug", "text/plain")]
    assert [request.key for request in bus.asked] == ["sceneq/query/room/status"] * 2


def test_nodes_on_a_hub_hear_and_ask_each_other() -> None:
    hub = FakeHub()
    first = hub.add(Toy, ToyParams(), replace(CONTEXT, node="first"))
    second = hub.add(Toy, ToyParams(), replace(CONTEXT, node="second", robot="echo", scene="hall"))
    hub.publish(POSE, POSE_7)
    first_bus, second_bus = hub.bus(first), hub.bus(second)
    assert first_bus.alive() == {"first", "second"}
    received = 0
    while received < 5:  # the second one hears its own echo, as on the real bus
        received += hub.step()
    assert len(first_bus.sent(POSE)) == 1
    assert len(second_bus.sent(POSE)) == 4
    assert len(first_bus.ask(QUERY_INSTANCES, scene="hall")) == 1
