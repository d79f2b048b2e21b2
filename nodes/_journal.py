"""What entered the map, in order: an append-only table, each row with its checksum.

A row is committed before anybody is told what came of it, so a map that was killed is never
behind what its readers know.
"""

import sqlite3
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import zstandard

from sceneq_nodes._database import check_pages, damage_named, open_database, used_bytes
from sceneq_nodes._set_aside import DamageError, StoreError

SCHEMA = 1
TABLES = """
CREATE TABLE entry (position INTEGER PRIMARY KEY, kind TEXT NOT NULL, first BLOB NOT NULL,
                    second BLOB NOT NULL, told INTEGER NOT NULL, crc INTEGER NOT NULL);
CREATE TABLE note (name TEXT PRIMARY KEY, value INTEGER NOT NULL)
"""
LEVEL = 1
MAX_PART_BYTES = 1 << 28
"""More than any message may have: a damaged length is not to eat the memory."""
DROPPED_AT_ONCE = 4
"""Old rows go a few with each new one, so that none of them waits for the disk."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One thing that entered the map: its place in the order and the messages as bytes.

    ``told`` is the number of the last delta before those that came of it.
    """

    position: int
    kind: str
    first: bytes
    second: bytes = b""
    told: int = 0


class Journal:
    """Entries by position, 1, 2, 3, ...; and a few numbers by name.

    Raises:
        StoreError: the file cannot be opened or written; from every method.
    """

    def __init__(self, path: Path, opened: sqlite3.Connection | None = None) -> None:
        """Open the file to write, or take a connection ``opened`` to read it."""
        self.path = path
        self._zip, self._unzip = zstandard.ZstdCompressor(LEVEL), zstandard.ZstdDecompressor()
        self._db = opened or open_database(path, TABLES, SCHEMA)

    def append(self, entry: Entry) -> None:
        """Commit an entry."""
        first, second = self._zip.compress(entry.first), self._zip.compress(entry.second)
        row = (entry.position, entry.kind, first, second, entry.told)
        self._write("INSERT INTO entry VALUES (?, ?, ?, ?, ?, ?)", (*row, _crc(*row)))

    def entries(self, after: int) -> Iterator[Entry]:
        """Yield the entries behind position ``after``, one after the other without a gap.

        Raises:
            DamageError: a damaged or missing row; those before it were yielded.
        """
        with damage_named():
            rows = self._db.execute(
                "SELECT * FROM entry WHERE position > ? ORDER BY position", (after,)
            )
            for expected, row in enumerate(rows, after + 1):
                if row[0] != expected:
                    raise DamageError(f"entries {expected} to {row[0] - 1} are missing")
                yield self._checked(*row)

    def of_kind(self, kind: str) -> Iterator[Entry]:
        """Yield the entries of one kind that are kept; raise ``DamageError`` at a damaged one."""
        with damage_named():
            rows = self._db.execute("SELECT * FROM entry WHERE kind = ? ORDER BY position", (kind,))
            for row in rows:
                yield self._checked(*row)

    def span(self) -> tuple[int, int]:
        """Return the first and the last position; (0, 0) when there is none."""
        with damage_named():
            first, last = self._db.execute(
                "SELECT min(position), max(position) FROM entry"
            ).fetchone()
        return first or 0, last or 0

    def used_bytes(self) -> int:
        """Return how much of the file holds something."""
        return used_bytes(self._db)

    def drop_some(self, before: int) -> None:
        """Let go of the oldest entries at and before a position, a few at a time."""
        first, _ = self.span()
        if 0 < first <= before:
            self.drop(min(before, first + DROPPED_AT_ONCE - 1))

    def drop(self, last: int) -> None:
        """Let go of all entries up to position ``last``."""
        self._write("DELETE FROM entry WHERE position <= ?", (last,))

    def number(self, name: str, default: int = 0) -> int:
        """Return the number kept under ``name``."""
        with damage_named():
            row = self._db.execute("SELECT value FROM note WHERE name = ?", (name,)).fetchone()
        return row[0] if row else default

    def note(self, name: str, value: int) -> None:
        """Keep a number under ``name``."""
        self._write("INSERT OR REPLACE INTO note VALUES (?, ?)", (name, value))

    def check_pages(self) -> None:
        """Read the whole file; raise ``DamageError`` with the first thing that is wrong."""
        check_pages(self._db)

    def close(self) -> None:
        """Let go of the file."""
        self._db.close()

    def _checked(
        self, position: int, kind: str, first: bytes, second: bytes, told: int, crc: int
    ) -> Entry:
        try:
            if crc != _crc(position, kind, first, second, told):
                raise DamageError(f"entry {position}: wrong checksum")
            one, other = (self._unzip.decompress(part, MAX_PART_BYTES) for part in (first, second))
        except (zstandard.ZstdError, TypeError, AttributeError) as error:
            raise DamageError(f"entry {position}: {error}") from error
        return Entry(position, kind, one, other, told)

    def _write(self, statement: str, values: tuple[object, ...]) -> None:
        try:
            self._db.execute(statement, values)
        except (sqlite3.Error, OSError) as error:
            raise StoreError(f"{self.path}: {error}") from error


def _crc(position: int, kind: str, first: bytes, second: bytes, told: int) -> int:
    head = f"{position}:{kind}:{told}".encode()
    return zlib.crc32(second, zlib.crc32(first, zlib.crc32(head)))
