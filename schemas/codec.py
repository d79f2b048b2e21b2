"""Dataclass <-> msgpack, driven by the type hints of the message classes.

A message travels as a map of its fields. Unknown fields are ignored, so a minor version may add
fields with defaults; a change of meaning takes a new ``VERSION`` and with it a new key.
"""

import operator
import types
from collections.abc import Callable
from dataclasses import MISSING, fields, is_dataclass
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin, get_type_hints

import msgpack
import numpy as np

from sceneq_schemas.arrays import ArraySpec, brief, pack_array, unpack_array
from sceneq_schemas.errors import DecodeError

MAX_MESSAGE_BYTES = 256 * 1024 * 1024
MAX_LIST = 16_384
MAX_MAP = 1_024
MAX_TEXT = 64 * 1024

M = TypeVar("M")
Convert = Callable[[Any, str], Any]


def encode(message: Any) -> bytes:
    """Return the msgpack bytes of a message.

    Raises:
        ValueError: a field of the wrong type or shape, or longer than readers accept.
    """
    name = type(message).__name__
    wire = _class_codec(type(message)).to_wire(message, name)
    packed: bytes = msgpack.packb(wire, use_bin_type=True)
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
            max_array_len=min(MAX_LIST, len(data)),
            max_map_len=min(MAX_MAP, len(data)),
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
        self.required = {
            f.name for f in fields(cls) if f.default is MISSING and f.default_factory is MISSING
        }
        self.conversions = {f.name: _conversion(hints[f.name]) for f in fields(cls)}

    def to_wire(self, message: Any, where: str) -> dict[str, Any]:
        if type(message) is not self.cls:
            raise _mismatch(where, self.cls.__name__, message)
        return {
            name: out(getattr(message, name), f"{where}.{name}")
            for name, (out, _) in self.conversions.items()
        }

    def from_wire(self, wire: Any, where: str) -> Any:
        if not isinstance(wire, dict):
            raise DecodeError(f"{where}: expected a map, got {brief(wire)}")
        missing = self.required - wire.keys()
        if missing:
            raise DecodeError(f"{where}: missing {', '.join(sorted(missing))}")
        return self.cls(
            **{
                name: back(wire[name], f"{where}.{name}")
                for name, (_, back) in self.conversions.items()
                if name in wire
            }
        )


_CODECS: dict[type, _ClassCodec] = {}


def _class_codec(cls: type) -> _ClassCodec:
    if cls not in _CODECS:
        _CODECS[cls] = _ClassCodec(cls)
    return _CODECS[cls]


def _conversion(hint: Any) -> tuple[Convert, Convert]:
    """Return (to_wire, from_wire) for one type hint."""
    origin, args = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _array_conversion(args[1])
    if origin in (Union, types.UnionType) and len(args) == 2 and args[1] is type(None):
        return _optional_conversion(args[0])
    if origin is tuple and args[1:] == (...,):
        return _tuple_conversion(args[0])
    if origin is dict and args[0] is str:
        return _dict_conversion(args[1])
    if is_dataclass(hint) and isinstance(hint, type):
        codec = _class_codec(hint)
        return codec.to_wire, codec.from_wire
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

    def to_wire(value: Any, where: str) -> Any:
        if len(value) > MAX_LIST:
            raise ValueError(f"{where}: {len(value)} items, the limit is {MAX_LIST}")
        return [out(item, f"{where}[{i}]") for i, item in enumerate(value)]

    def from_wire(wire: Any, where: str) -> Any:
        if not isinstance(wire, list):
            raise DecodeError(f"{where}: expected a list, got {brief(wire)}")
        return tuple(back(item, f"{where}[{i}]") for i, item in enumerate(wire))

    return to_wire, from_wire


def _dict_conversion(hint: Any) -> tuple[Convert, Convert]:
    out, back = _conversion(hint)

    def to_wire(value: Any, where: str) -> Any:
        if len(value) > MAX_MAP or not all(isinstance(key, str) for key in value):
            raise ValueError(f"{where}: expected at most {MAX_MAP} items with text keys")
        return {key: out(item, f"{where}.{key:.40}") for key, item in value.items()}

    def from_wire(wire: Any, where: str) -> Any:
        if not isinstance(wire, dict) or not all(isinstance(key, str) for key in wire):
            raise DecodeError(f"{where}: expected a map with text keys, got {brief(wire)}")
        return {key: back(item, f"{where}.{key:.40}") for key, item in wire.items()}

    return to_wire, from_wire


def _scalar_conversion(hint: Any) -> tuple[Convert, Convert]:
    if hint not in _SCALARS:
        raise TypeError(f"no wire form for {hint!r}")
    to_wire = _SCALARS[hint]

    def from_wire(wire: Any, where: str) -> Any:
        if hint is float and type(wire) is int:
            return float(wire)
        if type(wire) is not hint or (hint is int and not -(2**63) <= wire < 2**63):
            raise DecodeError(f"{where}: expected {hint.__name__}, got {brief(wire)}")
        return wire

    return to_wire, from_wire


def _int_to_wire(value: Any, where: str) -> int:
    try:
        number = operator.index(value)
    except TypeError:
        raise _mismatch(where, "int", value) from None
    if not -(2**63) <= number < 2**63:
        raise ValueError(f"{where}: {number} needs more than 64 bits")
    return number


def _float_to_wire(value: Any, where: str) -> float:
    if not isinstance(value, int | float | np.integer | np.floating):
        raise _mismatch(where, "float", value)
    return float(value)


def _bool_to_wire(value: Any, where: str) -> bool:
    if not isinstance(value, bool | np.bool_):
        raise _mismatch(where, "bool", value)
    return bool(value)


def _str_to_wire(value: Any, where: str) -> str:
    if not isinstance(value, str):
        raise _mismatch(where, "str", value)
    if len(value.encode(errors="replace")) > MAX_TEXT:
        raise ValueError(f"{where}: {len(value)} characters, the limit is {MAX_TEXT} bytes")
    return str(value)


def _bytes_to_wire(value: Any, where: str) -> bytes:
    if not isinstance(value, bytes | bytearray | memoryview):
        raise _mismatch(where, "bytes", value)
    return bytes(value)


_SCALARS: dict[Any, Convert] = {
    int: _int_to_wire,
    float: _float_to_wire,
    bool: _bool_to_wire,
    str: _str_to_wire,
    bytes: _bytes_to_wire,
}


def _mismatch(where: str, expected: str, value: Any) -> ValueError:
    return ValueError(f"{where}: expected {expected}, got {type(value).__name__}")
