"""Dataclass <-> msgpack, driven by the type hints of the message classes.

A message travels as a map of its fields. Unknown fields are ignored, so a minor version may add
fields with defaults; a change of meaning takes a new ``VERSION`` and with it a new key.
"""

import types
from collections.abc import Callable
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin, get_type_hints

import msgpack
from sceneq_schemas.arrays import ArraySpec, pack_array, unpack_array
from sceneq_schemas.errors import DecodeError

MAX_MESSAGE_BYTES = 256 * 1024 * 1024
MAX_LIST = 16_384
MAX_MAP = 1_024
MAX_TEXT = 64 * 1024

M = TypeVar("M")
Convert = Callable[[Any, str], Any]


def encode(message: Any) -> bytes:
    """Return the msgpack bytes of a message; raise ``ValueError`` on a field of wrong shape."""
    packed: bytes = msgpack.packb(_class_codec(type(message)).to_wire(message), use_bin_type=True)
    return packed


def decode(cls: type[M], data: bytes, max_bytes: int = MAX_MESSAGE_BYTES) -> M:
    """Return the message of type ``cls`` in ``data``.

    Raises:
        DecodeError: too large, not msgpack, a missing field, a wrong type, shape or byte count.
    """
    name = cls.__name__
    if len(data) > max_bytes:
        raise DecodeError(f"{name}: {len(data)} bytes, the limit is {max_bytes}")
    try:
        wire = msgpack.unpackb(
            data,
            raw=False,
            strict_map_key=True,
            max_bin_len=max_bytes,
            max_str_len=MAX_TEXT,
            max_array_len=MAX_LIST,
            max_map_len=MAX_MAP,
            max_ext_len=0,
        )
    except (ValueError, TypeError, RecursionError, msgpack.exceptions.UnpackException) as error:
        raise DecodeError(f"{name}: not msgpack: {error}") from error
    message: M = _class_codec(cls).from_wire(wire, name)
    return message


class _ClassCodec:
    """The conversions of one message class, worked out once from its type hints."""

    def __init__(self, cls: type) -> None:
        hints = get_type_hints(cls, include_extras=True)
        self.cls = cls
        self.fields = fields(cls)
        self.required = {f.name for f in self.fields if f.default is MISSING}
        self.conversions = {f.name: _conversion(hints[f.name]) for f in self.fields}

    def to_wire(self, message: Any) -> dict[str, Any]:
        name = self.cls.__name__
        return {
            f.name: self.conversions[f.name][0](getattr(message, f.name), f"{name}.{f.name}")
            for f in self.fields
        }

    def from_wire(self, wire: Any, where: str) -> Any:
        if not isinstance(wire, dict):
            raise DecodeError(f"{where}: expected a map, got {type(wire).__name__}")
        missing = self.required - wire.keys()
        if missing:
            raise DecodeError(f"{where}: missing {', '.join(sorted(missing))}")
        return self.cls(
            **{
                f.name: self.conversions[f.name][1](wire[f.name], f"{where}.{f.name}")
                for f in self.fields
                if f.name in wire
            }
        )


@cache
def _class_codec(cls: type) -> _ClassCodec:
    return _ClassCodec(cls)


def _conversion(hint: Any) -> tuple[Convert, Convert]:
    """Return (to_wire, from_wire) for one type hint."""
    origin, args = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _array_conversion(args[1])
    if origin in (Union, types.UnionType):
        return _optional_conversion(next(a for a in args if a is not type(None)))
    if origin is tuple:
        return _tuple_conversion(args[0])
    if origin is dict:
        return _dict_conversion(args[1])
    if is_dataclass(hint):
        codec = _class_codec(hint)
        return (lambda value, _: codec.to_wire(value)), codec.from_wire
    return _scalar_conversion(hint)


def _array_conversion(spec: ArraySpec) -> tuple[Convert, Convert]:
    return (
        lambda value, where: pack_array(value, spec, where),
        lambda wire, where: unpack_array(wire, spec, where),
    )


def _optional_conversion(hint: Any) -> tuple[Convert, Convert]:
    out, back = _conversion(hint)
    return (
        lambda value, where: None if value is None else out(value, where),
        lambda wire, where: None if wire is None else back(wire, where),
    )


def _tuple_conversion(hint: Any) -> tuple[Convert, Convert]:
    out, back = _conversion(hint)

    def from_wire(wire: Any, where: str) -> Any:
        if not isinstance(wire, list):
            raise DecodeError(f"{where}: expected a list, got {type(wire).__name__}")
        return tuple(back(item, f"{where}[{i}]") for i, item in enumerate(wire))

    return (lambda value, where: [out(item, where) for item in value]), from_wire


def _dict_conversion(hint: Any) -> tuple[Convert, Convert]:
    out, back = _conversion(hint)

    def from_wire(wire: Any, where: str) -> Any:
        if not isinstance(wire, dict):
            raise DecodeError(f"{where}: expected a map, got {type(wire).__name__}")
        return {str(key): back(item, f"{where}.{key!s:.40}") for key, item in wire.items()}

    return (lambda value, where: {k: out(v, where) for k, v in value.items()}), from_wire


def _scalar_conversion(hint: type) -> tuple[Convert, Convert]:
    if hint not in (int, float, str, bool, bytes):
        raise TypeError(f"no wire form for {hint!r}")

    def from_wire(wire: Any, where: str) -> Any:
        if hint is float and type(wire) is int:
            return float(wire)
        if type(wire) is not hint:
            raise DecodeError(f"{where}: expected {hint.__name__}, got {type(wire).__name__}")
        return wire

    return (lambda value, _: hint(value)), from_wire
