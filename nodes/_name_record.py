"""Names as lines of a file: JSON objects with a checksum, one for each thing that happened.

``teach`` has everything about a name, ``stand`` the instance and place it has moved to, ``forget``
the number of the one that was taken back. Vectors are little-endian float32, base64.
"""

import base64
import json
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_core.teaching.taught import Looks, Spot, Taught
from sceneq_core.teaching.wording import KINDS, clean

FORMAT = "sceneq.name.v1"
Record = dict[str, Any]


class ForeignError(ValueError):
    """A whole line, but of another version of this program."""


def teach_record(one: Taught) -> Record:
    """Return what is written when a name is given."""
    return {
        "op": "teach",
        "number": one.number,
        "name": one.name,
        "kind": one.kind,
        "by": one.by,
        "stamp_ns": one.stamp_ns,
        **_spot_record(one.spot),
        "model_id": one.looks.model_id,
        "descriptor": _text(one.looks.descriptor),
        "feature": _text(one.looks.feature),
    }


def stand_record(one: Taught) -> Record:
    """Return what is written when a name has another instance or place."""
    return {"op": "stand", "number": one.number, **_spot_record(one.spot)}


def forget_record(one: Taught) -> Record:
    """Return what is written when a name is taken back."""
    return {"op": "forget", "number": one.number}


def line_of(record: Record) -> bytes:
    """Return a record as a line with its checksum."""
    body = _body(record)
    return f'{body[:-1]},"crc":{zlib.crc32(body.encode())}}}\n'.encode()


def record_of(line: bytes) -> Record:
    """Return the record in a line.

    Raises:
        ForeignError: of another format.
        ValueError: torn or changed.
    """
    try:
        record = json.loads(line)
        crc = record.pop("crc")
    except (ValueError, RecursionError, TypeError, KeyError, AttributeError) as error:
        raise ValueError(f"no record: {error!r:.80}") from error
    if zlib.crc32(_body(record).encode()) != crc:
        raise ValueError("its checksum is wrong")
    if record.get("format") != FORMAT:
        raise ForeignError(f"format {record.get('format')!r:.40}")
    return dict(record)


def replay(records: Iterable[Record]) -> dict[int, Taught]:
    """Return the names that are left when everything has happened, by number.

    Raises:
        ValueError: a record without a field that it needs.
    """
    names: dict[int, Taught] = {}
    for record in records:
        try:
            _happen(names, record)
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            raise ValueError(f"record {record.get('number')}: {error!r:.80}") from error
    return names


def _happen(names: dict[int, Taught], record: Record) -> None:
    number = int(record["number"])
    if record["op"] == "teach":
        names[number] = _taught(number, record)
    elif record["op"] == "stand" and number in names:
        names[number] = replace(names[number], spot=_spot(record))
    elif record["op"] == "forget":
        names.pop(number, None)


def _taught(number: int, record: Mapping[str, Any]) -> Taught:
    if record["kind"] not in KINDS:
        raise ValueError(f"kind {record['kind']!r:.40}")
    return Taught(
        number=number,
        name=clean(record["name"]),
        kind=record["kind"],
        by=clean(record["by"], "by"),
        stamp_ns=int(record["stamp_ns"]),
        spot=_spot(record),
        looks=Looks(
            str(record["model_id"]), _vector(record["descriptor"]), _vector(record["feature"])
        ),
    )


def _spot_record(spot: Spot) -> Record:
    return {
        "instance_id": spot.instance_id,
        "map_epoch": spot.map_epoch,
        "centre_world": spot.centre_world.tolist(),
        "aabb_world": spot.aabb_world.tolist(),
    }


def _spot(record: Mapping[str, Any]) -> Spot:
    centre_world = np.array(record["centre_world"], np.float64)
    aabb_world = np.array(record["aabb_world"], np.float64)
    if centre_world.shape != (3,) or aabb_world.shape != (2, 3):
        raise ValueError(f"box of shape {aabb_world.shape}")
    return Spot(int(record["instance_id"]), int(record["map_epoch"]), centre_world, aabb_world)


def _body(record: Record) -> str:
    whole = {"format": FORMAT, **record}
    return json.dumps(whole, ensure_ascii=False, sort_keys=True, separators=(",", ":"))


def _text(vector: Float32) -> str:
    return base64.b64encode(vector.astype("<f4").tobytes()).decode()


def _vector(text: str) -> Float32:
    vector = np.frombuffer(base64.b64decode(text, validate=True), "<f4").astype(np.float32)
    if not np.isfinite(vector).all():
        raise ValueError("a vector that is not finite")
    return vector
