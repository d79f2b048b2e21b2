"""A ``State`` as bytes: its parts and the columns of its arrays as JSON, then the arrays."""

import io
import json
import math
import re
import struct
from collections.abc import Iterator
from typing import Any

import numpy as np
import zstandard

from sceneq_core.arrays import Array
from sceneq_core.state import State
from sceneq_nodes._set_aside import DamageError

LEVEL = 1
MAX_STATE_BYTES = 1 << 34
PIECE_BYTES = 1 << 24
_DTYPE = re.compile(r"[<>|][biufSU][0-9]{1,4}")
_LENGTH = struct.Struct("<Q")


def packed(state: State) -> bytes:
    """Return a small state compressed, in one piece."""
    return zstandard.ZstdCompressor(LEVEL).compress(b"".join(encoded(state)))


def unpacked(data: bytes) -> State:
    """Return what ``packed`` was given; raise ``DamageError`` for anything else."""
    try:
        return decoded(zstandard.ZstdDecompressor().stream_reader(io.BytesIO(data)))
    except (zstandard.ZstdError, ValueError, TypeError, KeyError) as error:
        raise DamageError(f"not a state: {error}") from error


def encoded(state: State) -> Iterator[bytes | memoryview]:
    """Yield the bytes of a state, piece by piece."""
    columns = [(array.dtype.str, array.shape) for array in state.arrays]
    told = json.dumps({"parts": state.parts, "arrays": columns}).encode()
    yield _LENGTH.pack(len(told))
    yield told
    for array in state.arrays:
        if array.nbytes:
            yield array.reshape(-1).view(np.uint8).data


def decoded(stream: Any) -> State:
    """Return the state whose bytes ``stream.read`` gives; raise ``ValueError`` for others."""
    told = json.loads(_exactly(stream, _LENGTH.unpack(_exactly(stream, _LENGTH.size))[0]))
    arrays = []
    for dtype, shape in told["arrays"]:
        arrays.append(_array(stream, dtype, shape))
    return State(told["parts"], arrays)


def _array(stream: Any, name: str, shape: list[int]) -> Array:
    if not _DTYPE.fullmatch(name) or not all(type(side) is int and side >= 0 for side in shape):
        raise ValueError(f"no array: {name!r:.20} of shape {shape!r:.60}")
    dtype = np.dtype(name)
    data = _exactly(stream, math.prod(shape) * dtype.itemsize)
    return np.frombuffer(data, dtype).reshape(shape)


def _exactly(stream: Any, size: int) -> bytearray:
    """Return so many bytes; what is claimed and not there is never made room for."""
    if size > MAX_STATE_BYTES:
        raise ValueError(f"{size} bytes in one piece")
    data = bytearray()
    while len(data) < size:
        piece = stream.read(min(PIECE_BYTES, size - len(data)))
        if not piece:
            raise ValueError(f"ends {size - len(data)} bytes early")
        data += piece
    return data
