"""Named pieces of a node's state in one file: what changes together is committed together."""

import logging
import sqlite3
import time
import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from sceneq_nodes._database import damage_named, open_database
from sceneq_nodes._folder_lock import FolderLock
from sceneq_nodes._set_aside import DamageError, NewerSchemaError, StoreError, set_aside

log = logging.getLogger(__name__)

SCHEMA = 1
TABLES = """
CREATE TABLE item (kind TEXT NOT NULL, number INTEGER NOT NULL, data BLOB NOT NULL,
                   crc INTEGER NOT NULL, PRIMARY KEY (kind, number))
"""
FORM, FIRST_FORM = "form", 1
"""The item that tells the form, and the form of items from before there was one."""
AGAIN_S = 5.0
"""How long to wait before a disk that failed is tried again."""


@dataclass(frozen=True, slots=True)
class Item:
    """A piece of state, by kind and number."""

    kind: str
    number: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Change:
    """What is new or different, and the (kind, number) of what is gone."""

    put: tuple[Item, ...] = ()
    gone: tuple[tuple[str, int], ...] = ()


class ItemStore:
    """The items of one node, in the file ``path``.

    When the disk fails the node goes on without it; as soon as it works again everything is
    written anew, so the file is that of one moment or of another, never a mixture.

    Args:
        path: the file.
        everything: returns all items as of now.
        count: counts ``store_failed`` and ``store_damaged``.
        form: version of what the data of the items hold; the file notes it. Data of an earlier
            one are set aside, for nobody reads them; a later one is left alone.

    Raises:
        StoreError: a newer schema or form, another process, or a folder that cannot be written.
    """

    def __init__(
        self,
        path: Path,
        everything: Callable[[], Iterable[Item]],
        count: Callable[[str], None],
        form: int = 1,
    ) -> None:
        self.path = path
        self._everything = everything
        self._count = count
        self._form = form
        self._again_s = 0.0
        self._is_behind = False
        try:
            path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            self._lock = FolderLock(path.parent, f"{path.stem}.lock")
        except OSError as error:
            raise StoreError(f"{path}: {error.strerror or error}") from error
        self._db = self._open()
        self._check_form()

    @property
    def is_behind(self) -> bool:
        """Whether the disk failed, and what is on it is old."""
        return self._is_behind

    def items(self) -> Iterator[Item]:
        """Yield all items by kind and number; a damaged one is told and left out.

        Raises:
            DamageError: the file as a whole is damaged.
        """
        with damage_named():
            rows = self._db.execute("SELECT * FROM item ORDER BY kind, number")
            for kind, number, data, crc in rows:
                if _is_whole(kind, number, data, crc):
                    if kind != FORM:
                        yield Item(kind, number, data)
                else:
                    self._count("store_damaged")
                    log.error("%s: %s %s: wrong checksum, left out", self.path, kind, number)

    def commit(self, change: Change) -> None:
        """Write a change before anybody is told of it; all or nothing of it is there."""
        if self._is_behind:
            if time.monotonic() >= self._again_s:
                self._catch_up()
            return
        try:
            self._write(change)
        except (sqlite3.Error, OSError) as error:
            self._fall_behind(error)

    def start_anew(self, reason: str) -> None:
        """Set the damaged file aside and go on with an empty one."""
        self._db.close()
        self._count("store_damaged")
        set_aside(self.path, reason)
        self._db = self._open()

    def close(self) -> None:
        """Let go of the file."""
        self._db.close()
        self._lock.close()

    def _open(self) -> sqlite3.Connection:
        return open_database(self.path, TABLES, SCHEMA)

    def _check_form(self) -> None:
        """Make sure that the items can be read, or set them aside; note the form of new ones."""
        try:
            found = self._found_form()
            if found > self._form:
                self.close()
                raise NewerSchemaError(self.path, found, self._form, "items of form")
            if found < self._form:
                self.start_anew(f"items of form {found}, this version reads {self._form}")
        except DamageError as damage:
            self.start_anew(str(damage))
        except OSError as error:
            raise StoreError(f"{self.path}: {error.strerror or error}") from error

    def _found_form(self) -> int:
        """Return the form of what is there, that of new items when nothing is."""
        with damage_named():
            rows = self._db.execute("SELECT number FROM item WHERE kind = ?", (FORM,)).fetchall()
            some = self._db.execute("SELECT 1 FROM item LIMIT 1").fetchone()
        if not some:
            return self._form
        return int(rows[0][0]) if rows else FIRST_FORM

    def _write(self, change: Change, *, anew: bool = False) -> None:
        put = (*change.put, Item(FORM, self._form, b""))
        rows = [(i.kind, i.number, i.data, _crc(i.kind, i.number, i.data)) for i in put]
        with self._db:
            self._db.execute("BEGIN IMMEDIATE")
            if anew:
                self._db.execute("DELETE FROM item")
            self._db.executemany("DELETE FROM item WHERE kind = ? AND number = ?", change.gone)
            self._db.executemany("INSERT OR REPLACE INTO item VALUES (?, ?, ?, ?)", rows)

    def _catch_up(self) -> None:
        try:
            self._write(Change(put=tuple(self._everything())), anew=True)
        except (sqlite3.Error, OSError) as error:
            self._fall_behind(error)
        else:
            self._is_behind = False
            log.warning("%s: durable again", self.path)

    def _fall_behind(self, error: Exception) -> None:
        self._count("store_failed")
        if not self._is_behind:
            log.error("%s: %s; the node goes on in memory only", self.path, error)
        self._is_behind, self._again_s = True, time.monotonic() + AGAIN_S


def damaged_items(connection: sqlite3.Connection) -> list[str]:
    """Return the items whose checksum is wrong."""
    with damage_named():
        rows = connection.execute("SELECT * FROM item ORDER BY kind, number")
        return [f"{row[0]} {row[1]}" for row in rows if not _is_whole(*row)]


def _is_whole(kind: str, number: int, data: object, crc: int) -> bool:
    return isinstance(data, bytes) and crc == _crc(kind, number, data)


def _crc(kind: str, number: int, data: bytes) -> int:
    return zlib.crc32(data, zlib.crc32(f"{kind}:{number}".encode()))
