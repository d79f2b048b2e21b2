"""Decoders of what the store keeps: the journal, checkpoints and taught names."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import zstandard

from sceneq_core.state import State
from sceneq_core.teaching.wording import KINDS
from sceneq_nodes._journal import Entry, Journal
from sceneq_nodes._json_fields import object_of, parse
from sceneq_nodes._name_record import line_of, record_of, replay
from sceneq_nodes._set_aside import DamageError, StoreError
from sceneq_nodes._state_bytes import encoded, packed, unpacked
from sceneq_tools.chaos.decoder import Decoder
from sceneq_tools.chaos.file_decoders import reading
from sceneq_tools.chaos.mutation import BYTES, JSON


def store_decoders(folder: Path) -> Iterator[Decoder]:
    """Yield them; the journal is written below ``folder`` first."""
    path = folder / "journal" / "journal.sqlite"
    path.parent.mkdir()
    seeds, refusals = (_journal_bytes(folder),), (DamageError, StoreError)
    journal = reading(path, _journal)
    yield Decoder("file: journal of the store", journal, seeds, BYTES, refusals)
    names = tuple(map(line_of, _NAMES))
    yield Decoder("taught name", record_of, names, BYTES, (ValueError,))
    records = tuple(json.dumps(record).encode() for record in _NAMES)
    yield Decoder("content of a name", _replay, records, JSON, (ValueError,))
    state = State([["dict", "a", 1], ["list", [0]]], [np.arange(6.0), np.zeros((2, 3), np.int32)])
    compressed, whole = packed(state), b"".join(encoded(state))
    yield Decoder("state of a checkpoint", unpacked, (compressed,), BYTES, (DamageError,))
    yield Decoder("content of a checkpoint", _state, (whole,), BYTES, (DamageError,))


def _state(data: bytes) -> object:
    return unpacked(zstandard.ZstdCompressor().compress(data))


def _replay(data: bytes) -> object:
    return replay([object_of(parse(data), "record")])


def _journal(path: Path) -> None:
    """Read what is there; a file that was set aside is not kept."""
    try:
        journal = Journal(path)
        try:
            journal.span()
            list(journal.entries(0))
            journal.check_pages()
        finally:
            journal.close()
    finally:
        for beside in path.parent.iterdir():
            beside.unlink()


def _journal_bytes(folder: Path) -> bytes:
    path = folder / "seed.sqlite"
    journal = Journal(path)
    for position in (1, 2, 3):
        journal.append(Entry(position, "keyframe", b"frame" * 40, b"masks" * 40, position))
    journal.close()
    return path.read_bytes()


_NAMES = (
    {
        "op": "teach",
        "number": 1,
        "name": "aunt Mary's mug",
        "kind": KINDS[0],
        "by": "anna",
        "stamp_ns": 5,
        "instance_id": 7,
        "map_epoch": 5,
        "centre_world": [0.0, 1.0, 2.0],
        "aabb_world": [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]],
        "model_id": "hash-v1",
        "descriptor": "AACAPw==",
        "feature": "AACAPw==",
    },
    {
        "op": "stand",
        "number": 1,
        "instance_id": 8,
        "map_epoch": 5,
        "centre_world": [0.0, 1.0, 2.0],
        "aabb_world": [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]],
    },
    {"op": "forget", "number": 1},
)
