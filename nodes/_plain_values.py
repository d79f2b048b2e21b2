"""Parameters that are already of their types, made without pydantic.

Loading pydantic and building its schema takes a fifth of a node's start, and a killed node has to
be back soon. Whatever is not plain is left to pydantic, which converts it or says what is wrong.
"""

from collections.abc import Mapping
from dataclasses import is_dataclass
from types import NoneType, UnionType
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

P = TypeVar("P")
SCALARS = (bool, int, float, str, NoneType)
EXACT = 2**53
"""Whole numbers below it are the same as floats."""


class NotPlainError(Exception):
    """A value that has to be converted or refused."""


def make(cls: type[P], values: Mapping[str, Any]) -> P:
    """Return ``cls(**values)``; nested dataclasses are made from mappings.

    Raises:
        NotPlainError: a value is not exactly of its annotated type, or ``cls`` refuses it.
    """
    hints = get_type_hints(cls)
    plain = {name: _plain(hints.get(name), value) for name, value in values.items()}
    try:
        return cls(**plain)
    except (TypeError, ValueError) as error:
        raise NotPlainError from error


def _plain(hint: Any, value: Any) -> Any:
    if hint in SCALARS and type(value) is hint:
        return value
    if hint is float and type(value) is int and abs(value) < EXACT:
        return float(value)
    if type(hint) is UnionType and len(parts := set(get_args(hint)) - {NoneType}) == 1:
        return None if value is None else _plain(parts.pop(), value)
    if type(value) is dict and is_dataclass(hint) and isinstance(hint, type):
        return make(hint, value)
    if type(value) is dict and get_origin(hint) is dict and hint.__args__ == (str, Any):
        return dict(value)
    raise NotPlainError
