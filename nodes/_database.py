"""A SQLite file of ours: its format and version known, damage found before it is used."""

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sceneq_nodes._set_aside import DamageError, NewerSchemaError, StoreError, set_aside

APPLICATION_ID = 0x53_43_51_31
"""``SCQ1`` in the header of the file, for `file` and for us."""
BUSY_S = 2.0
LOG_PAGES = 4000
"""16 MB of write-ahead log before it goes into the file: each time waits for the disk."""
DAMAGED = (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)
PRIVATE = 0o600


def open_database(path: Path, tables: str, schema: int) -> sqlite3.Connection:
    """Return the database at ``path``, made by the script ``tables`` if there is none.

    A commit outlives the process at once (write-ahead log) and a power cut after the next
    checkpoint of that log, some megabytes later at most; neither can tear it. A damaged file is
    set aside and replaced by an empty one.

    Raises:
        StoreError: a newer schema, another program's file, or a folder that cannot be written.
    """
    try:
        try:
            return _opened(path, tables, schema)
        except DamageError as damage:
            set_aside(path, str(damage))
            return _opened(path, tables, schema)
    except (DamageError, OSError, sqlite3.Error) as error:
        raise StoreError(f"{path}: {error}") from error


def open_to_read(path: Path, schema: int, *, alone: bool = False) -> sqlite3.Connection:
    """Return a connection to read from.

    Beside a writer it changes nothing; ``alone`` it needs no room on the disk, not even for the
    index that processes share.

    Raises:
        DamageError: no database of ours.
        StoreError: a newer schema, or not readable.
    """
    with damage_named():
        mode = "rw" if alone else "ro"
        connection = sqlite3.connect(f"file:{path}?mode={mode}", uri=True, timeout=BUSY_S)
        with _closed_unless_good(connection):
            if alone:
                connection.execute("PRAGMA locking_mode = EXCLUSIVE")
            _check_header(connection, path, schema)
    return connection


@contextmanager
def damage_named() -> Iterator[None]:
    """Turn SQLite's errors into ``DamageError`` for a damaged file, else into ``StoreError``."""
    try:
        yield
    except UnicodeDecodeError as error:  # of a message of SQLite that quotes what is damaged
        raise DamageError(f"no text: {error}") from error
    except sqlite3.Error as error:
        damaged = _primary_code(error) in DAMAGED
        raise (DamageError if damaged else StoreError)(str(error)) from error


def is_made(connection: sqlite3.Connection) -> bool:
    """Whether it has its tables: whoever makes it commits them all at once."""
    with damage_named():
        return bool(connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0])


def check_pages(connection: sqlite3.Connection) -> None:
    """Read every page; raise ``DamageError`` with the first thing that is wrong."""
    with damage_named():
        said = connection.execute("PRAGMA integrity_check(1)").fetchone()[0]
    if said != "ok":
        raise DamageError(str(said))


def used_bytes(connection: sqlite3.Connection) -> int:
    """Return how much of the file holds something."""
    pages, free, size = (
        connection.execute(f"PRAGMA {name}").fetchone()[0]
        for name in ("page_count", "freelist_count", "page_size")
    )
    return int((pages - free) * size)


def _opened(path: Path, tables: str, schema: int) -> sqlite3.Connection:
    path.touch(mode=PRIVATE, exist_ok=True)
    connection = sqlite3.connect(
        path, timeout=BUSY_S, isolation_level=None, check_same_thread=False
    )
    with _closed_unless_good(connection), damage_named():
        _check_header(connection, path, schema)
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = NORMAL")
        connection.execute(f"PRAGMA wal_autocheckpoint = {LOG_PAGES}")
        _make_tables(connection, tables, schema)
    return connection


@contextmanager
def _closed_unless_good(connection: sqlite3.Connection) -> Iterator[None]:
    try:
        yield
    except BaseException:
        connection.close()
        raise


def _check_header(connection: sqlite3.Connection, path: Path, schema: int) -> None:
    application = connection.execute("PRAGMA application_id").fetchone()[0]
    found = connection.execute("PRAGMA user_version").fetchone()[0]
    filled = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
    if filled and application != APPLICATION_ID:
        raise StoreError(f"{path}: another program's database")
    if found > schema:
        raise NewerSchemaError(path, found, schema)


def _make_tables(connection: sqlite3.Connection, tables: str, schema: int) -> None:
    if is_made(connection):
        return
    connection.executescript(
        f"BEGIN; PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = {schema};"
        f"{tables}; COMMIT;"
    )


def _primary_code(error: sqlite3.Error) -> int:
    return getattr(error, "sqlite_errorcode", 0) & 0xFF
