"""Reads an MCAP file from its beginning, whole or cut off where its writer was killed."""

import logging
import struct
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import zstandard
from mcap.exceptions import McapError
from mcap.records import Channel, Chunk, Header, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk

log = logging.getLogger(__name__)

MAX_RECORD_BYTES = 1024**3
BROKEN = (
    *(McapError, struct.error, zstandard.ZstdError, ValueError, EOFError),
    *(MemoryError, OverflowError),  # of a size that is damaged
)


@dataclass(frozen=True, slots=True)
class Recorded:
    """A message of a file: its topic, the name of its type, when it was logged, and its bytes."""

    topic: str
    type_name: str
    log_ns: int
    data: bytes


def library_of(path: Path) -> str:
    """Return the name of the program that wrote a file, empty when it is no MCAP file."""
    try:
        with path.open("rb") as file:
            first = next(iter(_reader(file).records))
    except (OSError, StopIteration, *BROKEN):
        return ""
    return first.library if isinstance(first, Header) else ""


def recorded(path: Path, topics: Collection[str], from_ns: int = 0) -> Iterator[Recorded]:
    """Yield the messages of ``topics`` from ``from_ns`` on, in the order they were written.

    A file that is cut off ends where it is, a damaged chunk is left out; both are logged.

    Raises:
        ValueError: it cannot be read at all.
    """
    channels: dict[int, tuple[str, str]] = {}
    schemas: dict[int, str] = {}
    try:
        with path.open("rb") as file:
            for record in _records(file, path):
                if isinstance(record, Schema):
                    schemas[record.id] = record.name
                elif isinstance(record, Channel):
                    channels[record.id] = record.topic, schemas.get(record.schema_id, "")
                elif isinstance(record, Message) and record.log_time >= from_ns:
                    topic, name = channels.get(record.channel_id, ("", ""))
                    if topic in topics:
                        yield Recorded(topic, name, record.log_time, record.data)
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}") from error


def _records(file: BinaryIO, path: Path) -> Iterator[Schema | Channel | Message]:
    read = 0
    try:
        for record in _reader(file).records:
            for inner in _opened(record, path) if isinstance(record, Chunk) else (record,):
                if isinstance(inner, Schema | Channel | Message):
                    read += 1
                    yield inner
    except BROKEN as error:
        if not read:
            raise ValueError(f"{path}: no MCAP file: {error!r:.120}") from error
        log.warning("%s ends after %d records: %r (was its writer killed?)", path, read, error)


def _opened(chunk: Chunk, path: Path) -> list[McapRecord]:
    """Return what is in a chunk, nothing when its checksum says that it is damaged."""
    try:
        return breakup_chunk(chunk, validate_crc=True)
    except BROKEN as error:
        at = chunk.message_start_time
        log.warning("%s: a chunk at %d ns is damaged and left out: %r", path, at, error)
        return []


def _reader(file: BinaryIO) -> StreamReader:
    return StreamReader(file, emit_chunks=True, record_size_limit=MAX_RECORD_BYTES)
