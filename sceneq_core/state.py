"""An object graph as plain values and arrays, and the same graph built from them again.

Only classes of ``sceneq_core`` are taken apart and built, field by field: no code runs that the
values could name. What is shared stays shared: two references to one object are two references to
one object afterwards.
"""

import importlib
import re
from collections import OrderedDict, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from sceneq_core.arrays import Array

OWN = re.compile(r"(sceneq_core\.(?:frame|ingest\.depth_view|(?:mapping|places|views)\.\w+)):(\w+)")
"""The classes that a state may hold, as ``module:name``."""
PLAIN = (bool, int, float, str, type(None))
NUMBERS = "biuf"


class StateError(ValueError):
    """What cannot be taken apart, or built: the message names it."""


@dataclass(frozen=True, slots=True)
class State:
    """An object graph taken apart.

    ``parts`` holds JSON values only, each part after those it refers to and the root last: the
    kind of the part, then its values. A value is a plain one or ``[i]``, which means part i.
    ``arrays`` are copies, in C order.
    """

    parts: list[list[Any]]
    arrays: list[Array]


def take_apart(root: object) -> State:
    """Return ``root`` and everything it refers to.

    Raises:
        StateError: an object of a foreign class, or one that refers to itself.
    """
    parting = _Parting()
    parting.value(root)
    return State(parting.parts, parting.arrays)


def build(state: State) -> Any:
    """Return the root of the object graph that ``state`` was taken from.

    Raises:
        StateError: parts that do not fit together, or fields that a dataclass does not have.
    """
    built: list[Any] = []
    try:
        for kind, *values in state.parts:
            built.append(_BUILDERS[kind](_Reader(built, state.arrays), values))
        return built[-1]
    except StateError:
        raise
    except (KeyError, IndexError, TypeError, AttributeError, ValueError) as error:
        raise StateError(f"part {len(built)}: {error!r:.200}") from error


def fields_of_classes(state: State) -> dict[str, set[str]]:
    """Return which fields the objects of each class have, ``module:name`` -> names."""
    found: dict[str, set[str]] = {}
    for kind, *values in state.parts:
        if kind == "object":
            found.setdefault(values[0], set()).update(values[1::2])
    return found


class _Parting:
    """Collects the parts of a graph, depth first."""

    def __init__(self) -> None:
        self.parts: list[list[Any]] = []
        self.arrays: list[Array] = []
        self._number: dict[int, int] = {}
        self._kept: list[object] = []  # as long as an object lives, no other has its id
        self._entered: set[int] = set()

    def value(self, value: Any) -> Any:
        """Return a plain value as it is, anything else as a reference to its part."""
        if type(value) in PLAIN:
            return value
        key = id(value)
        if key not in self._number:
            if key in self._entered:
                raise StateError(f"a {type(value).__name__} refers to itself")
            self._entered.add(key)
            part = self._part(value)
            self._number[key] = len(self.parts)
            self.parts.append(part)
            self._kept.append(value)
        return [self._number[key]]

    def _part(self, value: Any) -> list[Any]:
        name = type(value).__name__
        if isinstance(value, np.ndarray):
            return self._array_part(value)
        if isinstance(value, np.generic):
            return ["number", self._keep(np.array(value))]
        if type(value) is bytes:
            return ["bytes", self._keep(np.frombuffer(value, np.uint8))]
        if type(value) in (list, tuple, set, frozenset):
            return [name, *self._values(sorted(value) if "set" in name else value)]
        if type(value) is deque:
            return [name, value.maxlen, *self._values(value)]
        if type(value) in (dict, OrderedDict):
            return [name, *self._values(_flat(value.items()))]
        if type(value) is cKDTree:
            return ["tree", self.value(np.asarray(value.data))]
        return self._object_part(value)

    def _array_part(self, array: Array) -> list[Any]:
        if array.dtype.kind not in NUMBERS:
            raise StateError(f"an array of {array.dtype}")
        if array.flags.f_contiguous and not array.flags.c_contiguous:
            return ["turned", self._keep(array.T)]
        return ["array", self._keep(array)]

    def _object_part(self, value: object) -> list[Any]:
        cls = type(value)
        name = f"{cls.__module__}:{cls.__qualname__}"
        if not OWN.fullmatch(name):
            raise StateError(f"an object of {name}")
        return ["object", name, *self._values(_flat(_fields(value)))]

    def _values(self, values: Iterable[Any]) -> Iterator[Any]:
        return (self.value(value) for value in values)

    def _keep(self, array: Array) -> int:
        self.arrays.append(np.array(array, order="C"))
        return len(self.arrays) - 1


@dataclass(frozen=True, slots=True)
class _Reader:
    """What the parts read so far amount to."""

    built: list[Any]
    arrays: list[Array]

    def one(self, value: Any) -> Any:
        return self.built[value[0]] if type(value) is list else value

    def all(self, values: Sequence[Any]) -> list[Any]:
        return [self.one(value) for value in values]

    def pairs(self, values: Sequence[Any]) -> Iterator[tuple[Any, Any]]:
        flat = self.all(values)
        return zip(flat[::2], flat[1::2], strict=True)

    def array(self, values: Sequence[Any]) -> Array:
        array: Array = self.arrays[values[0]]
        return array


def _build_object(reader: _Reader, values: list[Any]) -> object:
    cls = _class(values[0])
    members = dict(reader.pairs(values[1:]))
    if is_dataclass(cls) and members.keys() != {f.name for f in fields(cls)}:
        raise StateError(f"{values[0]} has other fields now")
    made: object = cls.__new__(cls)
    for name, value in members.items():
        object.__setattr__(made, name, value)  # frozen dataclasses too
    return made


_BUILDERS: dict[str, Callable[[_Reader, list[Any]], Any]] = {
    "array": lambda reader, values: reader.array(values),
    "turned": lambda reader, values: reader.array(values).T,
    "number": lambda reader, values: reader.array(values)[()],
    "bytes": lambda reader, values: reader.array(values).tobytes(),
    "list": lambda reader, values: reader.all(values),
    "tuple": lambda reader, values: tuple(reader.all(values)),
    "set": lambda reader, values: set(reader.all(values)),
    "frozenset": lambda reader, values: frozenset(reader.all(values)),
    "deque": lambda reader, values: deque(reader.all(values[1:]), values[0]),
    "dict": lambda reader, values: dict(reader.pairs(values)),
    "OrderedDict": lambda reader, values: OrderedDict(reader.pairs(values)),
    "tree": lambda reader, values: cKDTree(reader.one(values[0])),
    "object": _build_object,
}


def _class(name: str) -> Any:
    match = OWN.fullmatch(name)
    if match is None:
        raise StateError(f"an object of {name!r:.80}")
    try:
        cls = getattr(importlib.import_module(match[1]), match[2])
    except (ImportError, AttributeError) as error:
        raise StateError(f"{name} is no more") from error
    if not isinstance(cls, type) or cls.__module__ != match[1]:
        raise StateError(f"{name} is no class of that module")
    return cls


def _fields(value: object) -> Iterator[tuple[str, Any]]:
    """Yield what an object holds, of its ``__slots__`` and its ``__dict__``."""
    for cls in type(value).__mro__:
        for name in getattr(cls, "__slots__", ()):
            if hasattr(value, name):
                yield name, getattr(value, name)
    yield from getattr(value, "__dict__", {}).items()


def _flat(pairs: Iterable[tuple[Any, Any]]) -> Iterator[Any]:
    return (value for pair in pairs for value in pair)
