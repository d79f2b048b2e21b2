"""Vertices of a PLY mesh or cloud; the rest of the file is not read."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sceneq_core.arrays import Float32

TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "float": "f4",
    "double": "f8",
    "float32": "f4",
    "float64": "f8",
}
ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}
AXES = ("x", "y", "z")
HEADER_LIMIT = 1 << 16


@dataclass(frozen=True, slots=True)
class _Header:
    """``form`` as the file says it; ``vertex`` are the (property, numpy type) of a vertex."""

    form: str
    count: int
    vertex: tuple[tuple[str, str], ...]


def read_vertices(path: Path) -> Float32:
    """Return the vertices float32 (N, 3) of a PLY file, in its own unit.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is no PLY, or does not hold what its header says.
    """
    data = path.read_bytes()
    head, end, body = data.partition(b"end_header\n")
    if not data.startswith(b"ply") or not end or len(head) > HEADER_LIMIT:
        raise ValueError("header: no PLY file")
    return _vertices(_header(head.decode("ascii")), body)


def _header(text: str) -> _Header:
    lines = [words for line in text.splitlines() if len(words := line.split()) > 1]
    elements = [words for words in lines if words[:1] == ["element"]]
    forms = [words[1] for words in lines if words[:1] == ["format"]]
    if not forms or (forms[0] not in ORDERS and forms[0] != "ascii"):
        raise ValueError(f"format: expected ascii or one of {', '.join(ORDERS)}, got {forms}")
    if not elements or elements[0][1] != "vertex" or len(elements[0]) < 3:
        raise ValueError("element vertex: must come first")
    start = lines.index(elements[0]) + 1
    stop = lines.index(elements[1]) if len(elements) > 1 else len(lines)
    properties = [words for words in lines[start:stop] if words[:1] == ["property"]]
    vertex = tuple((words[-1], _type(words)) for words in properties)
    if missing := [axis for axis in AXES if axis not in dict(vertex)]:
        raise ValueError(f"property {missing[0]}: missing in element vertex")
    return _Header(forms[0], int(elements[0][2]), vertex)


def _type(words: list[str]) -> str:
    if len(words) != 3 or words[1] not in TYPES:
        raise ValueError(f"property {words[-1]}: expected a number, got {' '.join(words[1:-1])}")
    return TYPES[words[1]]


def _vertices(header: _Header, body: bytes) -> Float32:
    if header.form == "ascii":
        return _ascii_vertices(header, body)
    order = ORDERS[header.form]
    row = np.dtype([(name, order + kind) for name, kind in header.vertex])
    if len(body) < header.count * row.itemsize:
        raise ValueError(f"element vertex: {header.count} expected, the file is cut off")
    table = np.frombuffer(body, row, header.count)
    return np.stack([table[axis] for axis in AXES], axis=1).astype(np.float32)


def _ascii_vertices(header: _Header, body: bytes) -> Float32:
    rows = body.decode("ascii").splitlines()[: header.count]
    if len(rows) < header.count:
        raise ValueError(f"element vertex: {header.count} expected, got {len(rows)}")
    names = [name for name, _ in header.vertex]
    columns = [names.index(axis) for axis in AXES]
    table = [row.split() for row in rows]
    if any(len(words) < len(names) for words in table):
        raise ValueError(f"element vertex: expected {len(names)} numbers in every line")
    values = [[float(words[at]) for at in columns] for words in table]
    return np.array(values, np.float32).reshape(-1, 3)
