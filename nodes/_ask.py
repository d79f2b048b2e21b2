"""What a client wants from a query: question, count, mode and format."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import msgpack

from sceneq_nodes._bus import QueryError, Reply, Request
from sceneq_nodes._wire import json_bytes

MAX_PAYLOAD_BYTES = 64 * 1024
PICTURE_STARTS = (b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff")
DEFAULT_K = 5
MODES = ("", "fast", "reason")
FORMATS = ("json", "msgpack")


@dataclass(frozen=True, slots=True)
class Ask:
    """A request, read.

    ``text`` is the question, "" = none; ``k`` and ``instance_id`` are ``None`` when not given;
    ``after``: list instances with a higher id; ``mode`` is "", "fast" or "reason";
    ``deadline_ms``: when the answer must be there, from its arrival; ``labels``: what an instance
    may be called, () = the scene's label set; ``picture``: a JPEG or PNG file, b"" = none.
    """

    text: str
    k: int | None
    instance_id: int | None
    after: int
    mode: str
    fmt: str
    deadline_ms: int | None = None
    labels: tuple[str, ...] = ()
    picture: bytes = b""


def read_ask(request: Request) -> Ask:
    """Return what ``request`` asks for; the payload beats the parameters.

    A payload is the question itself, or with ``application/json`` or ``application/msgpack`` an
    object such as ``{"q": "red mug", "k": 3}``.

    Raises:
        QueryError: ``bad_request`` with what is wrong.
    """
    said = fields_of(request)
    return Ask(
        text=_text(said.get("q", "")),
        k=count_in(said, "k", 1),
        instance_id=count_in(said, "id", 0),
        after=count_in(said, "after", 0) or 0,
        mode=choice_in(said, "mode", "", MODES),
        fmt=format_of(request, said),
        deadline_ms=count_in(said, "deadline_ms", 1),
        labels=label_names(said.get("labels", "")),
        picture=request.payload if _is_picture(request) else b"",
    )


def fields_of(request: Request) -> dict[str, Any]:
    """Return all that a request says; raises ``QueryError`` as ``read_ask``.

    A payload that is a text is the field ``q``.
    """
    return {**request.parameters, **_payload(request)}


def format_of(request: Request, said: Mapping[str, Any]) -> str:
    """Return how to answer: as asked for, else as the request itself is written."""
    default = "msgpack" if _media_type(request) == "application/msgpack" else "json"
    return choice_in(said, "fmt", default, FORMATS)


def left_s(ask: Ask, spent_ms: float) -> float:
    """Return how long a reasoner may take when ``spent_ms`` have gone by."""
    if ask.deadline_ms is None:
        return math.inf
    return max(0.0, (ask.deadline_ms - spent_ms) / 1e3)


def reply(body: Mapping[str, Any], schema: str, fmt: str) -> Reply:
    """Return ``body`` as JSON or msgpack, its encoding naming the schema."""
    if fmt == "msgpack":
        return Reply(msgpack.packb(body), f"application/msgpack;sceneq.{schema}.v1")
    return Reply(json_bytes(body), f"application/json;sceneq.{schema}.v1")


def _payload(request: Request) -> dict[str, Any]:
    if not request.payload or _is_picture(request):
        return {}
    if len(request.payload) > MAX_PAYLOAD_BYTES:
        raise _bad(f"payload of {len(request.payload)} bytes, the limit is {MAX_PAYLOAD_BYTES}")
    media = _media_type(request)
    try:
        if media == "application/json":
            return _object(json.loads(request.payload))
        if media == "application/msgpack":
            return _object(msgpack.unpackb(request.payload, max_map_len=64, max_array_len=256))
        return {"q": request.payload.decode()}
    except (ValueError, RecursionError, msgpack.exceptions.UnpackException) as error:
        raise _bad(f"payload is not valid {media or 'UTF-8 text'}: {error}") from error


def _is_picture(request: Request) -> bool:
    """Tell by the first bytes: third-party command lines name no media type."""
    return request.payload.startswith(PICTURE_STARTS) or _media_type(request).startswith("image/")


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


def label_names(value: Any) -> tuple[str, ...]:
    """Return names separated by commas, or given as a list; each counts once."""
    names = value.split(",") if isinstance(value, str) else value
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise _bad("labels: expected texts, such as mug,cup,bowl")
    return tuple(dict.fromkeys(name.strip() for name in names if name.strip()))


def count_in(said: Mapping[str, Any], name: str, least: int) -> int | None:
    """Return the whole number in a field, ``None`` when it is not there."""
    value = said.get(name)
    if value is None:
        return None
    text = str(value)
    if isinstance(value, bool) or not text.isascii() or not text.isdigit() or len(text) > 18:
        raise _bad(f"{name}: expected a whole number, got {text!r:.40}")
    if int(text) < least:
        raise _bad(f"{name}: {text} is below {least}")
    return int(text)


def choice_in(said: Mapping[str, Any], name: str, default: str, known: tuple[str, ...]) -> str:
    """Return the word in a field, one of ``known``."""
    value = said.get(name, default)
    if value not in known:
        raise _bad(f"{name}: {value!r:.40}, known: {', '.join(filter(None, known))}")
    return str(value)


def _bad(message: str) -> QueryError:
    return QueryError("bad_request", message, "try ?q=red mug;k=3;mode=reason;fmt=json")
