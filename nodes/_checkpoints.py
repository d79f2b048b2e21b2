"""The whole state of a node in a file, that is there whole or not at all.

A file is a line of JSON (format, schema, position), the state compressed, and the sha256 of all of
it. It is written beside its place, forced to the disk, and renamed; the last few are kept.
"""

import contextlib
import hashlib
import json
import os
import re
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import IO, cast

import zstandard

from sceneq_core.state import State
from sceneq_nodes._database import PRIVATE
from sceneq_nodes._set_aside import DamageError, NewerSchemaError, sync_folder
from sceneq_nodes._state_bytes import decoded, encoded

FORMAT = "sceneq.checkpoint"
SCHEMA = 1
NAME = re.compile(r"checkpoint-(\d{12})\.sceneq")
UNFINISHED = ".unfinished"
LEVEL = 1
MAX_HEADER_BYTES = 4096


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """A file and the position in the journal whose state it holds."""

    path: Path
    position: int


class Checkpoints:
    """The checkpoints in ``folder``."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def newest_first(self) -> list[Checkpoint]:
        """Return what there is; whether it can be read shows only when it is."""
        found = [
            Checkpoint(path, int(match[1]))
            for path in self.folder.iterdir()
            if (match := NAME.fullmatch(path.name))
        ]
        return sorted(found, key=lambda checkpoint: -checkpoint.position)

    def write(self, position: int, state: State) -> Checkpoint:
        """Write the state at ``position``; raise ``OSError`` and leave all as it was."""
        path = self.folder / f"checkpoint-{position:012d}.sceneq"
        unfinished = path.with_name(path.name + UNFINISHED)
        try:
            _write(unfinished, position, state)
            unfinished.rename(path)
            sync_folder(self.folder)
        except OSError:
            with contextlib.suppress(OSError):
                unfinished.unlink(missing_ok=True)
            raise
        return Checkpoint(path, position)

    def keep_newest(self, count: int) -> None:
        """Delete older ones, and what was being written when a process ended."""
        unfinished = self.folder.glob(f"checkpoint-*{UNFINISHED}")
        for path in (*unfinished, *(c.path for c in self.newest_first()[count:])):
            path.unlink(missing_ok=True)


def read(checkpoint: Checkpoint) -> State:
    """Return the state in a file.

    Raises:
        DamageError: torn or changed.
        NewerSchemaError: written by a later version.
        OSError: not readable.
    """
    data = checkpoint.path.read_bytes()
    header, _, _ = data[:MAX_HEADER_BYTES].partition(b"\n")
    _check_header(header, checkpoint)
    body, digest = data[len(header) + 1 : -32], data[-32:]
    if hashlib.sha256(memoryview(data)[:-32]).digest() != digest:
        raise DamageError("wrong checksum")
    try:
        return decoded(zstandard.ZstdDecompressor().stream_reader(body))
    except (zstandard.ZstdError, ValueError, TypeError) as error:
        raise DamageError(f"not a state: {error}") from error


def _check_header(header: bytes, checkpoint: Checkpoint) -> None:
    try:
        said = json.loads(header)
        is_ours, schema = said["format"] == FORMAT, int(said["schema"])
        position = int(said["position"])
    except (ValueError, KeyError, TypeError) as error:
        raise DamageError("no header") from error
    if is_ours and schema > SCHEMA:
        raise NewerSchemaError(checkpoint.path, schema, SCHEMA)
    if not is_ours or position != checkpoint.position:
        raise DamageError("the header is another file's")


def _write(path: Path, position: int, state: State) -> None:
    app = version("sceneq")
    header = {"format": FORMAT, "schema": SCHEMA, "app": app, "position": position}
    descriptor = os.open(path, os.O_CREAT | os.O_TRUNC | os.O_WRONLY, PRIVATE)
    with open(descriptor, "wb", buffering=0) as file:
        hashing = _Hashing(file)
        hashing.write(json.dumps(header).encode() + b"\n")
        target = cast("IO[bytes]", hashing)  # all that zstandard wants of it is `write`
        writer = zstandard.ZstdCompressor(LEVEL).stream_writer(target, closefd=False)
        with writer:
            for chunk in encoded(state):
                writer.write(chunk)
        _write_all(file, hashing.digest())
        os.fsync(descriptor)


class _Hashing:
    """A file that knows the sha256 of what was written to it."""

    def __init__(self, file: "IO[bytes]") -> None:
        self._file = file
        self._sha256 = hashlib.sha256()

    def write(self, data: bytes) -> int:
        self._sha256.update(data)
        _write_all(self._file, data)
        return len(data)

    def digest(self) -> bytes:
        return self._sha256.digest()


def _write_all(file: "IO[bytes]", data: bytes) -> None:
    """Write everything: the system may take a part, as it does when the disk is nearly full."""
    rest = memoryview(data)
    while rest:
        rest = rest[file.write(rest) :]
