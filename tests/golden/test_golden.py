"""The bytes of every message version, as they were when the version was made.

A released file is never rewritten: other versions of the program and recordings depend on it. A
message that gains fields with defaults keeps its VERSION; what it was before moves to earlier/ and
must still decode. When a message gets a new VERSION, add its example to
``tests/support/messages.py`` and write the file:

    PYTHONPATH=tests python tests/golden/test_golden.py
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from sceneq_schemas.codec import decode, encode
from sceneq_schemas.page import Page
from sceneq_schemas.topics import TOPICS

from support.messages import EXAMPLES, same

FOLDER = Path(__file__).parent
BY_SCHEMA = {message.SCHEMA: message for message in EXAMPLES}


def path(schema: str) -> Path:
    return FOLDER / f"{schema}.msgpack"


@pytest.mark.parametrize("schema", BY_SCHEMA)
def test_bytes_do_not_change(schema: str) -> None:
    assert encode(BY_SCHEMA[schema]) == path(schema).read_bytes()


@pytest.mark.parametrize("schema", BY_SCHEMA)
def test_old_bytes_decode_to_the_same_message(schema: str) -> None:
    message = BY_SCHEMA[schema]
    assert same(decode(type(message), path(schema).read_bytes()), message)


def before_a_field_was_added(schema: str) -> tuple[Any, Any]:
    """Return what the bytes of then say, and the message of now."""
    now = BY_SCHEMA[schema]
    return decode(type(now), (FOLDER / "earlier" / f"{schema}.msgpack").read_bytes()), now


def test_a_frame_from_before_a_field_was_added_still_decodes() -> None:
    old, now = before_a_field_was_added("sceneq.frame.v1")
    assert same(replace(now, after=-1), old)


def test_a_map_from_before_a_field_was_added_still_decodes() -> None:
    old, now = before_a_field_was_added("sceneq.map.v1")
    assert (old.epoch, old.seq) == (now.epoch, now.seq)
    assert same(old.voxel_coord, now.voxel_coord)
    assert (old.events, old.quarantined) == ((), "")


def test_every_typed_topic_has_a_golden_file() -> None:
    schemas = {t.message.SCHEMA for t in TOPICS if t.message is not None}
    schemas |= {Page.SCHEMA}  # no topic: a part of any large reply
    assert schemas == set(BY_SCHEMA) == {p.stem for p in FOLDER.glob("*.msgpack")}


def test_the_schema_names_the_version() -> None:
    for schema, message in BY_SCHEMA.items():
        assert schema.endswith(f".v{message.VERSION}")


def write_missing() -> None:
    """Write the file of every version that has none."""
    for schema, message in BY_SCHEMA.items():
        if not path(schema).exists():
            path(schema).write_bytes(encode(message))


if __name__ == "__main__":
    write_missing()
