"""Arrays on the wire: ``{"dt": "<u2", "sh": [480, 640], "b": ...}``, checked before allocation."""

import math
from dataclasses import dataclass
from typing import Any, TypeGuard

import numpy as np
import numpy.typing as npt

from sceneq_schemas.errors import DecodeError

Array = npt.NDArray[Any]
MAX_DIMENSIONS = 4


@dataclass(frozen=True, slots=True)
class ArraySpec:
    """The dtype and shape an array field must have; ``None`` in the shape is any length."""

    dtype: str
    shape: tuple[int | None, ...]

    def accepts(self, shape: tuple[int, ...]) -> bool:
        """Tell whether ``shape`` fits this specification."""
        return len(shape) == len(self.shape) and all(
            want is None or want == got for want, got in zip(self.shape, shape, strict=True)
        )

    def __str__(self) -> str:
        lengths = ", ".join("any" if n is None else str(n) for n in self.shape)
        return f"{self.dtype}[{lengths}]"


def pack_array(array: Array, spec: ArraySpec, field: str) -> dict[str, Any]:
    """Return the wire form of ``array``; raise ``ValueError`` when it does not fit ``spec``.

    A wider dtype is narrowed, but integers only when every value survives.
    """
    if not spec.accepts(array.shape):
        raise ValueError(f"{field}: expected {spec}, got shape {array.shape}")
    exact = np.ascontiguousarray(_cast(array, np.dtype(spec.dtype), field))
    return {"dt": spec.dtype, "sh": list(array.shape), "b": exact.tobytes()}


def unpack_array(wire: Any, spec: ArraySpec, field: str) -> Array:
    """Return a read-only view on the bytes of ``wire``.

    Raises:
        DecodeError: dtype, shape or byte count differ from ``spec`` or from each other.
    """
    if not isinstance(wire, dict):
        raise DecodeError(f"{field}: expected an array, got {brief(wire)}")
    dt, shape, data = wire.get("dt"), wire.get("sh"), wire.get("b")
    if dt != spec.dtype or not isinstance(data, bytes):
        raise DecodeError(f"{field}: expected {spec}, got dtype {brief(dt)} in {brief(data)}")
    if not _is_shape(shape) or not spec.accepts(tuple(shape)):
        raise DecodeError(f"{field}: expected {spec}, got shape {brief(shape)}")
    dtype = np.dtype(spec.dtype)
    if math.prod(shape) * dtype.itemsize != len(data):
        raise DecodeError(f"{field}: shape {shape} does not match {len(data)} bytes")
    return np.frombuffer(data, dtype=dtype).reshape(shape)


def brief(value: Any) -> str:
    """Name a value from the bus in few words; its ``repr`` may be larger than the message."""
    if value is None or isinstance(value, int | float):
        return repr(value)
    if isinstance(value, str | bytes):
        return repr(value[:40])
    if _is_shape(value):
        return repr(value)
    return f"{type(value).__name__} of {len(value)}"


def _cast(array: Array, dtype: np.dtype[Any], field: str) -> Array:
    same_kind = np.can_cast(array.dtype, dtype, "same_kind")
    integers = array.dtype.kind in "iu" and dtype.kind in "iu"
    if array.size and not same_kind and not integers:
        raise ValueError(f"{field}: {array.dtype} does not become {dtype.str}")
    cast: Array = array.astype(dtype, copy=False)
    if array.dtype.kind in "iu" and not np.array_equal(cast, array):
        raise ValueError(f"{field}: a value does not fit into {dtype.str}")
    return cast


def _is_shape(value: Any) -> TypeGuard[list[int]]:
    return (
        isinstance(value, list)
        and len(value) <= MAX_DIMENSIONS
        and all(type(n) is int and 0 <= n < 2**31 for n in value)
    )
