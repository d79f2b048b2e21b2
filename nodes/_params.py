"""Parameters from the outside world, checked against the dataclass that names them."""

import difflib
from collections.abc import Mapping
from dataclasses import MISSING, fields
from typing import TYPE_CHECKING, Any, TypeVar

from sceneq_nodes._plain_values import NotPlainError, make

if TYPE_CHECKING:
    from pydantic import TypeAdapter

P = TypeVar("P")


class ParamError(ValueError):
    """A parameter that cannot be used: where it stands, what was given, how to mend it."""

    def __init__(self, path: tuple[str | int, ...], value: Any, message: str, hint: str) -> None:
        super().__init__(f"{'.'.join(map(str, path))}: {message}" + (f" ({hint})" if hint else ""))
        self.path = path
        self.value = value
        self.message = message
        self.hint = hint


def validate(cls: type[P], values: Mapping[str, Any], path: tuple[str | int, ...] = ()) -> P:
    """Return ``cls(**values)`` with every value checked and converted to its annotated type.

    Raises:
        ParamError: unknown key, missing key or wrong value; the first one found.
    """
    known = {f.name: f for f in fields(cls)}  # type: ignore[arg-type]
    for key, value in values.items():
        if key not in known:
            raise ParamError((*path, key), value, "unknown key", did_you_mean(key, known))
    for name, field in known.items():
        if name not in values and field.default is MISSING and field.default_factory is MISSING:
            raise ParamError((*path, name), None, "missing key", f"add '{name}: ...'")
    try:
        return make(cls, values)
    except NotPlainError:
        return _convert(cls, values, path)


def _convert(cls: type[P], values: Mapping[str, Any], path: tuple[str | int, ...]) -> P:
    from pydantic import ValidationError

    try:
        return _adapter(cls).validate_python(dict(values))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = (*path, *first["loc"])
        raise ParamError(where, first.get("input"), first["msg"], "") from error


def did_you_mean(word: str, known: Mapping[str, Any] | set[str]) -> str:
    """Return a hint that names the closest known word, or all of them."""
    close = difflib.get_close_matches(word, list(known), n=1)
    return f"did you mean '{close[0]}'?" if close else f"known: {', '.join(sorted(known))}"


_ADAPTERS: dict[Any, "TypeAdapter[Any]"] = {}


def _adapter(cls: type[P]) -> "TypeAdapter[P]":
    from pydantic import TypeAdapter

    if cls not in _ADAPTERS:
        _ADAPTERS[cls] = TypeAdapter(cls)
    return _ADAPTERS[cls]
