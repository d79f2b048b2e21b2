"""Codec ``sceneq`` of the third-party ``zenoh`` command: any of our messages as readable text.

zenoh get -s 'sceneq/query/kitchen/instances?q=mug' --decoder sceneq
"""

import json
from dataclasses import fields, is_dataclass
from typing import Any

import msgpack
import numpy as np

from sceneq_schemas.codec import decode as decode_message
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.topics import TOPICS, Topic
from sceneq_tools.answer_text import as_text

MAX_TEXT = 120
MAX_ITEMS = 20
ANSWER_FIELDS = {"status", "instances", "confidence"}


def decode(key: Any, data: bytes) -> str:
    """Return ``data`` as text: an answer as a table, anything else as its key and fields.

    The command tells a codec the key and not the encoding, so JSON is tried first; what nobody
    can read is described, not raised.
    """
    try:
        return _told(key, json.loads(data))
    except (ValueError, RecursionError):
        pass  # not JSON: a message of ours, or msgpack of somebody else's
    topic = _topic(str(key))
    try:
        if topic is not None and topic.message is not None:
            return _told(key, decode_message(topic.message, data, topic.max_bytes))
        return _told(key, msgpack.unpackb(data))
    except (DecodeError, ValueError, msgpack.exceptions.UnpackException) as error:
        return f"{len(data)} bytes that are no message of {key}: {error}"


def encode(key: Any, text: str) -> bytes:
    """Return what travels: JSON in compact form, anything else as the UTF-8 text it is."""
    try:
        return json.dumps(json.loads(text), ensure_ascii=False, separators=(",", ":")).encode()
    except ValueError:
        return text.encode()


def _topic(key: str) -> Topic | None:
    return next((topic for topic in TOPICS if topic.ids(key) is not None), None)


def _told(key: Any, value: Any) -> str:
    if isinstance(value, dict) and value.keys() >= ANSWER_FIELDS:
        return as_text(value)
    return "\n".join([str(key), *_lines(value, "  ")])


def _lines(value: Any, indent: str) -> list[str]:
    lines = []
    for name, item in _items(value):
        if is_dataclass(item) or isinstance(item, dict):
            lines += [f"{indent}{name}:", *_lines(item, indent + "  ")]
        elif isinstance(item, list | tuple) and any(_is_record(part) for part in item):
            lines += [f"{indent}{name}: {len(item)}", *_records(item, indent + "  ")]
        else:
            lines.append(f"{indent}{name}: {_short(item)}")
    return lines


def _records(items: list[Any] | tuple[Any, ...], indent: str) -> list[str]:
    lines = []
    for part in items[:MAX_ITEMS]:
        inline = ", ".join(f"{name} {_short(item)}" for name, item in _items(part))
        lines.append(f"{indent}- {inline}")
    if len(items) > MAX_ITEMS:
        lines.append(f"{indent}- and {len(items) - MAX_ITEMS} more")
    return lines


def _items(value: Any) -> list[tuple[str, Any]]:
    if is_dataclass(value):
        return [(f.name, getattr(value, f.name)) for f in fields(value)]
    return list(value.items()) if isinstance(value, dict) else [("value", value)]


def _is_record(value: Any) -> bool:
    return is_dataclass(value) or isinstance(value, dict)


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray):
        if value.size <= 16:
            return str(np.round(value, 4).tolist())
        return f"{value.dtype}{list(value.shape)}"
    if isinstance(value, bytes):
        return f"{len(value)} bytes"
    if isinstance(value, list | tuple) and any(_is_record(part) for part in value):
        return f"{len(value)} items"
    if _is_record(value):
        return f"{{{len(_items(value))} fields}}"
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False, default=repr)
    return text if len(text) <= MAX_TEXT else f"{text[:MAX_TEXT]}..."
