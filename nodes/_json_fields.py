"""Fields of JSON from the network, checked and bounded; all raise ``DecodeError`` with the name."""

import json
import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_schemas.errors import DecodeError

MAX_TEXT = 1000


def parse(data: bytes) -> Any:
    """Return what the JSON in ``data`` holds."""
    try:
        return json.loads(data)
    except (ValueError, RecursionError) as error:
        raise DecodeError(f"not JSON: {error}") from error


def object_of(wire: Any, what: str) -> dict[str, Any]:
    """Return an object, called ``what`` when it is none."""
    if not isinstance(wire, dict):
        raise DecodeError(f"{what}: expected an object, got {type(wire).__name__}")
    return wire


def list_of(
    wire: dict[str, Any], name: str, limit: int, convert: Callable[[Any], Any]
) -> list[Any]:
    """Return a field with at most ``limit`` entries, each converted."""
    value = wire.get(name)
    if not isinstance(value, list) or len(value) > limit:
        raise DecodeError(f"{name}: expected a list of at most {limit}")
    return [convert(item) for item in value]


def text_of(wire: dict[str, Any], name: str) -> str:
    """Return a field with a text of at most ``MAX_TEXT`` characters."""
    value = wire.get(name)
    if not isinstance(value, str) or len(value) > MAX_TEXT:
        raise DecodeError(f"{name}: expected a text of at most {MAX_TEXT} characters")
    return value


def flag(wire: dict[str, Any], name: str, *, otherwise: bool) -> bool:
    """Return a field that is true or false, ``otherwise`` when it is not there."""
    value = wire.get(name, otherwise)
    if not isinstance(value, bool):
        raise DecodeError(f"{name}: expected true or false, got {value!r:.40}")
    return value


def integer(value: Any, name: str) -> int:
    """Return a whole number of 64 bits."""
    if type(value) is not int or not -(2**63) <= value < 2**63:
        raise DecodeError(f"{name}: expected an integer, got {value!r:.40}")
    return value


def number(value: Any, name: str) -> float:
    """Return a finite number."""
    if type(value) not in (int, float) or not abs(value) <= sys.float_info.max:
        raise DecodeError(f"{name}: expected a finite number, got {value!r:.40}")
    return float(value)


def probability(value: Any, name: str) -> float:
    """Return a number from 0 to 1."""
    p = number(value, name)
    if not 0.0 <= p <= 1.0:
        raise DecodeError(f"{name}: {p} is not a probability")
    return p


def numbers(wire: dict[str, Any], name: str, shape: tuple[int, ...]) -> Float64:
    """Return a field with finite numbers, float64 of ``shape``."""
    try:
        array = np.array(wire.get(name), np.float64)
    except (ValueError, TypeError, OverflowError) as error:
        raise DecodeError(f"{name}: expected numbers: {error}") from error
    if array.shape != shape or not np.isfinite(array).all():
        raise DecodeError(f"{name}: expected {shape} finite numbers, got shape {array.shape}")
    return array


def unit(vector: Float64) -> Float64:
    """Return a vector (3,) of any length but none, at length 1."""
    largest = np.abs(vector).max()
    if not largest > 0:
        raise DecodeError("up_world: has no length")
    scaled = vector / largest
    length_1: Float64 = scaled / np.linalg.norm(scaled)
    return length_1
