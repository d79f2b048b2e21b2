"""What a client wants from a query: question, count, mode and format."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import msgpack

from sceneq_nodes._bus import QueryError, Reply, Request
from sceneq_nodes._wire import json_bytes

MAX_PAYLOAD_BYTES = 64 * 1024
DEFAULT_K = 5
MODES = ("", "fast", "reason")
FORMATS = ("json", "msgpack")


@dataclass(frozen=True, slots=True)
class Ask:
    """A request, read.

    ``text`` is the question, "" = none; ``k`` and ``instance_id`` are ``None`` when not given;
    ``after``: list instances with a higher id; ``mode`` is "", "fast" or "reason";
    ``deadline_ms``: when the answer must be there, from its arrival.
    """

    text: str
    k: int | None
    instance_id: int | None
    after: int
    mode: str
    fmt: str
    deadline_ms: int | None = None


def read_ask(request: Request) -> Ask:
    """Return what ``request`` asks for; the payload beats the parameters.

    A payload is the question itself, or with ``application/json`` or ``application/msgpack`` an
    object such as ``{"q": "red mug", "k": 3}``.

    Raises:
        QueryError: ``bad_request`` with what is wrong.
    """
    said: dict[str, Any] = {**request.parameters, **_payload(request)}
    default_fmt = "msgpack" if _media_type(request) == "application/msgpack" else "json"
    return Ask(
        text=_text(said.get("q", "")),
        k=_count(said, "k", 1),
        instance_id=_count(said, "id", 0),
        after=_count(said, "after", 0) or 0,
        mode=_choice(said, "mode", "", MODES),
        fmt=_choice(said, "fmt", default_fmt, FORMATS),
        deadline_ms=_count(said, "deadline_ms", 1),
    )


def reply(body: Mapping[str, Any], schema: str, fmt: str) -> Reply:
    """Return ``body`` as JSON or msgpack, its encoding naming the schema."""
    if fmt == "msgpack":
        return Reply(msgpack.packb(body), f"application/msgpack;sceneq.{schema}.v1")
    return Reply(json_bytes(body), f"application/json;sceneq.{schema}.v1")


def _payload(request: Request) -> dict[str, Any]:
    if not request.payload:
        return {}
    if len(request.payload) > MAX_PAYLOAD_BYTES:
        raise _bad(f"payload of {len(request.payload)} bytes, the limit is {MAX_PAYLOAD_BYTES}")
    media = _media_type(request)
    try:
        if media == "application/json":
            return _object(json.loads(request.payload))
        if media == "application/msgpack":
            return _object(msgpack.unpackb(request.payload, max_map_len=64, max_array_len=64))
        return {"q": request.payload.decode()}
    except (ValueError, RecursionError, msgpack.exceptions.UnpackException) as error:
        raise _bad(f"payload is not valid {media or 'UTF-8 text'}: {error}") from error


def _media_type(request: Request) -> str:
    return request.encoding.partition(";")[0].strip()


def _object(value: Any) -> dict[str, Any]:
    if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
        raise ValueError(f"expected an object such as {{'q': '...'}}, got {type(value).__name__}")
    return value


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise _bad(f"q: expected a text, got {type(value).__name__}")
    return value.strip()


def _count(said: Mapping[str, Any], name: str, least: int) -> int | None:
    value = said.get(name)
    if value is None:
        return None
    text = str(value)
    if isinstance(value, bool) or not text.isascii() or not text.isdigit() or len(text) > 18:
        raise _bad(f"{name}: expected a whole number, got {text!r:.40}")
    if int(text) < least:
        raise _bad(f"{name}: {text} is below {least}")
    return int(text)


def _choice(said: Mapping[str, Any], name: str, default: str, known: tuple[str, ...]) -> str:
    value = said.get(name, default)
    if value not in known:
        raise _bad(f"{name}: {value!r:.40}, known: {', '.join(filter(None, known))}")
    return str(value)


def _bad(message: str) -> QueryError:
    return QueryError("bad_request", message, "try ?q=red mug;k=3;mode=reason;fmt=json")
