"""Arrays on the wire: ``{"dt": "<u2", "sh": [480, 640], "b": ...}``, checked before allocation."""

import math
from dataclasses import dataclass
from typing import Any

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
    """Return the wire form of ``array``; raise ``ValueError`` when it does not match ``spec``."""
    contiguous = np.ascontiguousarray(array, dtype=np.dtype(spec.dtype))
    if not spec.accepts(array.shape):
        raise ValueError(f"{field}: expected {spec}, got shape {array.shape}")
    return {"dt": spec.dtype, "sh": list(array.shape), "b": contiguous.tobytes()}


def unpack_array(wire: Any, spec: ArraySpec, field: str) -> Array:
    """Return a read-only view on the bytes of ``wire``.

    Raises:
        DecodeError: dtype, shape or byte count differ from ``spec`` or from each other.
    """
    if not isinstance(wire, dict):
        raise DecodeError(f"{field}: expected an array, got {type(wire).__name__}")
    data, shape = wire.get("b"), wire.get("sh")
    if wire.get("dt") != spec.dtype or not isinstance(data, bytes):
        raise DecodeError(f"{field}: expected {spec}, got dtype {wire.get('dt')!r}")
    if not _is_shape(shape) or not spec.accepts(tuple(shape)):
        raise DecodeError(f"{field}: expected {spec}, got shape {shape!r:.80}")
    dtype = np.dtype(spec.dtype)
    if math.prod(shape) * dtype.itemsize != len(data):
        raise DecodeError(f"{field}: shape {shape} does not match {len(data)} bytes")
    return np.frombuffer(data, dtype=dtype).reshape(shape)


def _is_shape(value: Any) -> bool:
    return (
        isinstance(value, list)
        and len(value) <= MAX_DIMENSIONS
        and all(type(n) is int and 0 <= n < 2**31 for n in value)
    )
