"""A topic's message as bytes and back: msgpack by the codec, or JSON when it has no type."""

import json
from typing import Any

from sceneq_schemas.codec import decode, encode
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.topics import Topic


def to_bytes(topic: Topic, message: Any) -> bytes:
    """Return ``message`` as the bytes of ``topic``.

    Raises:
        ValueError: not the topic's type, a field that does not fit, or over ``topic.max_bytes``.
    """
    if topic.message is not None and type(message) is not topic.message:
        want, got = topic.message.__name__, type(message).__name__
        raise ValueError(f"{topic.name}: expected {want}, got {got}")
    data = encode(message) if topic.message else json_bytes(message)
    if len(data) > topic.max_bytes:
        raise ValueError(f"{topic.name}: {len(data)} bytes, the limit is {topic.max_bytes}")
    return data


def from_bytes(topic: Topic, data: bytes) -> Any:
    """Return the message in ``data``; raise ``DecodeError`` when it is not one of ``topic``."""
    if topic.message is not None:
        return decode(topic.message, data, topic.max_bytes)
    if len(data) > topic.max_bytes:
        raise DecodeError(f"{topic.name}: {len(data)} bytes, the limit is {topic.max_bytes}")
    try:
        return json.loads(data)
    except (ValueError, RecursionError) as error:
        raise DecodeError(f"{topic.name}: not JSON: {error}") from error


def json_bytes(value: Any) -> bytes:
    """Return compact UTF-8 JSON; raise ``ValueError`` on NaN and infinity."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.encode()
