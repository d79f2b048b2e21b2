"""Damages bytes the way links, disks and strangers do; the same seed gives the same damage."""

import json
import random
import struct
from collections.abc import Callable, Sequence
from copy import deepcopy
from typing import Any

import msgpack

BYTES, MSGPACK, JSON = "bytes", "msgpack", "json"
MOST_DAMAGES = 4
LONG_TEXT = 70_000

_HUGE = b"\xff\xff\xff\xff"
CHUNKS = (
    *(code + _HUGE for code in (b"\xc6", b"\xc9", b"\xdb", b"\xdd", b"\xdf")),
    *(code + b"\xff\xff" for code in (b"\xc5", b"\xc8", b"\xda", b"\xdc", b"\xde")),
    b"\xc1",
    b"\x91" * 600,
    b"\x81\xa1b" * 400,
    b"\xcb\x7f\xf8\x00\x00\x00\x00\x00\x00",
    b"\xd3" + struct.pack(">q", -(2**63)),
    b"\x28\xb5\x2f\xfd",
    b"\xff\xc0\x00\x11\x08\xff\xff\xff\xff\x03",
    *(b"[" * 2_000, b"9" * 400, b"-1e999", b"NaN", b"null", b'{"a":', b"\\ud800", b"\xff", b"]"),
    *(b"\x00", b"\n", b";", b"=", b"%00", b"%", b",", b"..", b"\xe2\x80\xae", b"and and of the "),
)
"""What a decoder meets only on purpose: headers of msgpack that lie, and pieces of text."""
VALUES: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1, 2**31, 2**63 - 1, -(2**63), 2**64 - 1),
    *(float("nan"), float("inf"), -float("inf"), 1e308, -0.0, 1e-320),
    *("", "\x00", "|O", "<f8", "nan", "x" * LONG_TEXT, "\ud7ff\uffff", b"", b"\x00" * 64),
    *([], {}, [[]], [-1], [0, 0], [2**31 - 1, 2**31 - 1], [1.5], {"": None}, [None] * 300),
)
NUMBERS = (
    *(struct.pack("<f", x) for x in (float("nan"), float("inf"), 3e38, -3e38, 1e-40, 0.0)),
    *(struct.pack("<d", x) for x in (float("nan"), float("inf"), 1e308, -1e308, 1e-320, 0.0)),
    *(struct.pack("<i", x) for x in (-1, -(2**31), 2**31 - 1, 2**26, 2**20)),
    *(struct.pack("<q", x) for x in (-1, -(2**63), 2**63 - 1)),
)
"""What may stand in an array."""
LENGTHS = (0, 1, 0x7F, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF, 2**63 - 1, 2**64 - 1)


class Mutator:
    """Makes damaged copies of ``seeds``, which are valid inputs in the same ``form``."""

    def __init__(self, seeds: Sequence[bytes], form: str, chance: random.Random) -> None:
        self._seeds = seeds
        self._form = form
        self._chance = chance
        self._damages: tuple[Callable[[bytearray], None], ...] = (
            *(self._flip, self._cut, self._insert, self._overwrite, self._repeat, self._remove),
            *(self._noise, self._length, self._splice),
        )

    def next(self) -> bytes:
        """Return one more."""
        data = self._chance.choice(self._seeds)
        if self._form != BYTES and self._chance.random() < 0.6:
            data = self._with_other_values(data)
            if self._chance.random() < 0.8:
                return data
        damaged = bytearray(data)
        for _ in range(self._chance.randint(1, MOST_DAMAGES)):
            self._chance.choice(self._damages)(damaged)
        return bytes(damaged)

    def _with_other_values(self, data: bytes) -> bytes:
        """Return the same structure with one to three values replaced, removed or swapped."""
        read = json.loads if self._form == JSON else _unpacked
        root = [read(data)]
        replace = self._chance.choice((_replace_one, _change_one, _change_one))
        for _ in range(self._chance.randint(1, 3)):
            replace(root, self._chance)
        return _written(root[0], self._form)

    def _at(self, data: bytearray) -> int:
        return self._chance.randint(0, len(data))

    def _flip(self, data: bytearray) -> None:
        if data:
            data[self._chance.randrange(len(data))] ^= 1 << self._chance.randrange(8)

    def _cut(self, data: bytearray) -> None:
        del data[self._at(data) :]

    def _insert(self, data: bytearray) -> None:
        at = self._at(data)
        data[at:at] = self._chance.choice(CHUNKS)

    def _overwrite(self, data: bytearray) -> None:
        at, chunk = self._at(data), self._chance.choice(CHUNKS)
        data[at : at + len(chunk)] = chunk

    def _repeat(self, data: bytearray) -> None:
        start, end = sorted((self._at(data), self._at(data)))
        data[end:end] = data[start:end]

    def _remove(self, data: bytearray) -> None:
        start, end = sorted((self._at(data), self._at(data)))
        del data[start:end]

    def _noise(self, data: bytearray) -> None:
        at = self._at(data)
        data[at : at + 8] = self._chance.randbytes(8)

    def _length(self, data: bytearray) -> None:
        """Overwrite what may be a length, in any width and order."""
        width, order = self._chance.choice("BHIQ"), self._chance.choice("<>")
        mask = (1 << 8 * struct.calcsize(width)) - 1
        at = self._at(data)
        field = struct.pack(order + width, self._chance.choice(LENGTHS) & mask)
        data[at : at + len(field)] = field

    def _splice(self, data: bytearray) -> None:
        other = self._chance.choice(self._seeds)
        data[self._at(data) :] = other[self._chance.randint(0, len(other)) :]


def _unpacked(data: bytes) -> Any:
    return msgpack.unpackb(data, raw=False, strict_map_key=False)


def _written(value: Any, form: str) -> bytes:
    if form == MSGPACK:
        packed: bytes = msgpack.packb(value, use_bin_type=True)
        return packed
    return json.dumps(value, default=lambda data: data.decode("latin-1")).encode()


def _replace_one(root: list[Any], chance: random.Random) -> None:
    places = list(_places(root))
    holder, key = chance.choice(places)
    match chance.randrange(6):
        case 0 if holder is not root:
            del holder[key]
        case 1:
            other, other_key = chance.choice(places)
            holder[key] = other[other_key]
            if _is_deep(root):
                holder[key] = None
        case 2 if isinstance(holder[key], list) and holder[key]:
            holder[key] = holder[key] * chance.choice((2, 20))
        case _:
            holder[key] = deepcopy(chance.choice(VALUES))


def _change_one(root: list[Any], chance: random.Random) -> None:
    """Replace a value by another one of its type: what passes the schema."""
    places = _places(root)
    leaves = [(h, key) for h, key in places if not isinstance(h[key], dict | list)]
    holder, key = chance.choice(leaves or places)
    value = holder[key]
    if isinstance(value, bytes) and value:
        number = chance.choice(NUMBERS)
        at = chance.randrange(0, len(value), 4) if len(value) > 3 else 0
        holder[key] = (value[:at] + number + value[at + len(number) :])[: len(value)]
    else:
        same = [other for other in VALUES if type(other) is type(value)]
        holder[key] = chance.choice(same) if same else None


def _places(root: list[Any]) -> list[tuple[Any, Any]]:
    """Return (container, key) of every value, the root's first."""
    found: list[tuple[Any, Any]] = []
    waiting: list[Any] = [root]
    while waiting:
        holder = waiting.pop()
        keys = list(holder) if isinstance(holder, dict) else range(min(len(holder), 64))
        for key in keys:
            found.append((holder, key))
            if isinstance(holder[key], dict | list):
                waiting.append(holder[key])
    return found


def _is_deep(value: Any, depth: int = 0) -> bool:
    """Tell whether a structure holds itself, or nearly so."""
    if depth > 40:
        return True
    parts = value.values() if isinstance(value, dict) else value
    return any(_is_deep(part, depth + 1) for part in parts if isinstance(part, dict | list))
