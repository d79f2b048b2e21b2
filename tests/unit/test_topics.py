"""The table of keys: unique, versioned, and the same in both directions."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_schemas.topics import (
    FRAME,
    HEALTH,
    ID,
    LIVE,
    MAP_DELTA,
    QUERY_ASK,
    TOPICS,
    VIEW_IMAGE,
    Delivery,
    Topic,
)

IDS = st.from_regex(ID, fullmatch=True)


@given(data=st.data(), topic=st.sampled_from(TOPICS))
def test_ids_come_back_from_the_key(data: st.DataObject, topic: Topic) -> None:
    ids = {name: data.draw(IDS) for name in topic.id_names}
    assert topic.ids(topic.key(**ids)) == ids


@given(data=st.data())
def test_a_key_belongs_to_one_topic(data: st.DataObject) -> None:
    topic = data.draw(st.sampled_from(TOPICS))
    key = topic.key(**{name: data.draw(IDS) for name in topic.id_names})
    assert [t for t in TOPICS if t.ids(key) is not None] == [topic]


def test_selector_leaves_open_what_is_not_given() -> None:
    assert FRAME.selector(robot="r1") == "sceneq/frame/r1/*/v1"
    assert HEALTH.selector() == "sceneq/health/*"
    assert LIVE.selector() == "sceneq/@live/*/*"


@pytest.mark.parametrize("bad", ["", "A", "a b", "a/b", "*", "ä", "a\n", "@x"])
def test_user_text_never_enters_a_key(bad: str) -> None:
    with pytest.raises(ValueError, match="must match"):
        MAP_DELTA.key(scene=bad)
    with pytest.raises(ValueError, match="must match"):
        MAP_DELTA.selector(scene=bad)
    assert MAP_DELTA.ids(f"sceneq/map/{bad}/delta/v1") is None


def test_wrong_ids_are_named() -> None:
    with pytest.raises(ValueError, match="frame: expected the ids robot, sensor, got robot"):
        FRAME.key(robot="r1")
    with pytest.raises(ValueError, match="health: expected the ids node, got none"):
        HEALTH.key()
    with pytest.raises(ValueError, match="frame: no id scene in"):
        FRAME.selector(scene="room")


def test_keys_of_other_topics_are_not_ours() -> None:
    assert FRAME.ids("sceneq/frame/r1/cam/v2") is None
    assert FRAME.ids("sceneq/frame/r1/v1") is None
    assert FRAME.ids("sceneq/frame/r1/cam/extra/v1") is None


def test_the_encoding_names_the_schema() -> None:
    assert FRAME.encoding == "application/msgpack;sceneq.frame.v1"
    assert QUERY_ASK.encoding == "application/json;sceneq.answer.v1"
    assert VIEW_IMAGE.encoding == "image/jpeg"


def test_typed_topics_carry_the_version_in_the_key() -> None:
    for topic in TOPICS:
        if topic.message is not None:
            assert topic.pattern.endswith(f"/v{topic.message.VERSION}"), topic.name
            assert topic.max_bytes > 0
        if topic.delivery is Delivery.STATE:
            assert {"epoch", "seq", "full"} <= set(topic.message.__dataclass_fields__)


def test_bulk_state_is_hidden_from_wildcards() -> None:
    for topic in TOPICS:
        if "snapshot" in topic.name or "image" in topic.name or "live" in topic.name:
            assert "/@" in topic.pattern, topic.name
