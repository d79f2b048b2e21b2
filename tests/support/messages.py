"""One example of every message, and what equal messages are."""

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from sceneq_tools.chaos.examples import EXAMPLES, T_WORLD_CAMERA, K, ramp

__all__ = ["EXAMPLES", "T_WORLD_CAMERA", "K", "ramp", "same"]


def same(one: Any, other: Any) -> bool:
    """Tell whether two messages are equal, bit by bit in their arrays."""
    if isinstance(one, np.ndarray):
        return one.shape == other.shape and one.dtype == other.dtype and _bits(one) == _bits(other)
    if is_dataclass(one):
        return type(one) is type(other) and all(
            same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one)
        )
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return bool(one == other) or (one != one and other != other)


def _bits(array: Any) -> bytes:
    return np.ascontiguousarray(array).tobytes()
