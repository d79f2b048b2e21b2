"""What a client wants to be called how, and which name it wants taken back."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sceneq_core.routing.scene import Box
from sceneq_core.teaching.wording import KINDS, clean, clean_name, kind_of
from sceneq_nodes._ask import choice_in, count_in, fields_of, format_of
from sceneq_nodes._bus import QueryError, Request

SOMEBODY = "somebody"
HINT = "try ?id=7;name=aunt Mary's mug;by=anna or ?view=120;x=310;y=200;name=..."


@dataclass(frozen=True, slots=True)
class TeachRequest:
    """A name for an instance: by ``instance_id``, or by a ``point`` or ``box`` (pixels) in the
    keyframe ``view``.
    """

    name: str
    kind: str
    by: str
    instance_id: int | None
    view: int | None
    point: tuple[float, float] | None
    box: Box | None
    fmt: str


@dataclass(frozen=True, slots=True)
class ForgetRequest:
    """Take back a ``name``, all names of an instance, or that name of that instance."""

    name: str
    instance_id: int | None
    fmt: str


def read_teach(request: Request) -> TeachRequest:
    """Return what ``request`` wants to teach; a text as payload is the name.

    Raises:
        QueryError: ``bad_request`` with what is wrong.
    """
    said = fields_of(request)
    try:
        name = clean_name(_text(said, "name" if "name" in said else "q"))
        by = clean(_text(said, "by", SOMEBODY), "by")
    except ValueError as error:
        raise bad(str(error)) from error
    instance_id, view = count_in(said, "id", 0), count_in(said, "view", 0)
    if (instance_id is None) == (view is None):
        raise bad("say which instance: id=7, or a place in a picture: view=120;x=310;y=200")
    point, box = _point(said), _box(said)
    if view is not None and (point is None) == (box is None):
        raise bad("view: say where in it: x=310;y=200, or box=100,80,160,140")
    kind = choice_in(said, "kind", kind_of(name), KINDS)
    return TeachRequest(name, kind, by, instance_id, view, point, box, format_of(request, said))


def read_forget(request: Request) -> ForgetRequest:
    """Return what ``request`` wants forgotten; raises ``QueryError`` as ``read_teach``."""
    said = fields_of(request)
    name, instance_id = _text(said, "name" if "name" in said else "q"), count_in(said, "id", 0)
    if not name and instance_id is None:
        raise QueryError("bad_request", "say what to forget", "try ?name=aunt Mary's mug or ?id=7")
    try:
        name = clean_name(name) if name else ""
    except ValueError as error:
        raise bad(str(error)) from error
    return ForgetRequest(name, instance_id, format_of(request, said))


def bad(message: str) -> QueryError:
    """Return the error of a request that cannot be understood."""
    return QueryError("bad_request", message, HINT)


def _text(said: Mapping[str, Any], field: str, default: str = "") -> str:
    value = said.get(field, default)
    if not isinstance(value, str):
        raise bad(f"{field}: expected a text, got {type(value).__name__}")
    return value.strip()


def _point(said: Mapping[str, Any]) -> tuple[float, float] | None:
    if "x" not in said and "y" not in said:
        return None
    return _number(said.get("x"), "x"), _number(said.get("y"), "y")


def _box(said: Mapping[str, Any]) -> Box | None:
    if "box" not in said:
        return None
    value = said["box"]
    parts = value.split(",") if isinstance(value, str) else value
    if not isinstance(parts, list) or len(parts) != 4:
        raise bad("box: expected four numbers such as 100,80,160,140")
    left, top, right, bottom = (_number(part, "box") for part in parts)
    if not (left < right and top < bottom):
        raise bad("box: expected left,top,right,bottom with left < right and top < bottom")
    return left, top, right, bottom


def _number(value: Any, field: str) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if isinstance(value, bool) or not math.isfinite(number):
        raise bad(f"{field}: expected a number, got {value!r:.40}")
    return number
