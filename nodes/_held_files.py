"""The files with what visits hold: whose they are, how much is in them, and what may be done."""

import contextlib
import logging
import re
import shutil
import sqlite3
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from sceneq_core.places.visit import Visit
from sceneq_nodes._database import is_made, open_to_read
from sceneq_nodes._journal import SCHEMA, Journal
from sceneq_nodes._set_aside import COMPANIONS, DamageError, StoreError, set_aside

log = logging.getLogger(__name__)

NAME = re.compile(r"held-(?P<robot>[a-z0-9_-]+)-[0-9a-f]{8}\.sqlite")
NUMBERS = ("stamp_ns", "fingerprint", "seq")
"""The last one noted, and never negative, tells that all are there."""

HALF_MADE = sqlite3.SQLITE_READONLY_ROLLBACK
"""Only to make a file takes a journal to roll back, none of what is written into it later."""


@dataclass(frozen=True, slots=True)
class Caller:
    """What names a visit before the map numbers it: who came, and the first keyframe."""

    robot: str
    seq: int
    stamp_ns: int
    fingerprint: int

    @classmethod
    def of(cls, visit: Visit) -> "Caller":
        """Return what ``visit`` was named by."""
        return cls(visit.robot, visit.first_seq, visit.first_stamp_ns, visit.fingerprint)

    @property
    def file_name(self) -> str:
        """Return the name of the file with what the visit holds."""
        numbers = f"{self.seq}:{self.stamp_ns}:{self.fingerprint}".encode()
        return f"held-{self.robot}-{zlib.crc32(numbers):08x}.sqlite"


@dataclass(frozen=True, slots=True)
class Waiting:
    """How much a visit holds that is not placed."""

    caller: Caller
    keyframes: int
    path: Path


def held_files(folder: Path) -> list[Path]:
    """Return the files with what visits hold, the one last written to first."""
    found = [path for path in folder.glob("held-*.sqlite") if NAME.fullmatch(path.name)]
    return sorted(found, key=lambda path: (-touched_s(path), path.name))


def touched_s(path: Path) -> float:
    """Return when a file was last written to, in seconds since 1970; 0 when it is gone."""
    times = [0.0]
    for one in (path, path.with_name(path.name + COMPANIONS[0])):
        with contextlib.suppress(FileNotFoundError):
            times.append(one.stat().st_mtime)
    return max(times)


def read_waiting(path: Path) -> Waiting:
    """Return how much waits in a file, also beside who writes it.

    Raises:
        StoreError: not readable.
        DamageError: damaged.
    """
    with contextlib.closing(Journal(path, open_to_read(path, SCHEMA))) as journal:
        first, last = journal.span()
        return Waiting(caller_of(journal), last - first + 1 if last else 0, path)


def waiting_in(path: Path) -> list[Waiting]:
    """Return what waits in a file that may be in use: nothing where it is begun or placed just now.

    So with one whose maker was killed before it was made: the next to write there does it anew.

    Raises:
        StoreError: not readable.
        DamageError: damaged.
    """
    try:
        return [read_waiting(path)] if _is_begun(path) else []
    except StoreError as error:
        half_made = getattr(error.__cause__, "sqlite_errorcode", None) == HALF_MADE
        if path.exists() and not half_made:
            raise
        return []


def _is_begun(path: Path) -> bool:
    with contextlib.closing(open_to_read(path, SCHEMA)) as connection:
        journal = Journal(path, connection)
        return is_made(connection) and (journal.number("seq", -1) >= 0 or journal.span()[1] > 0)


def waiting_text(visits: int, keyframes: int) -> str:
    """Return how much waits for its place in words, empty when nothing does."""
    if not visits:
        return ""
    return f"{visits} visit{'s' * (visits > 1)} not placed, {keyframes} keyframes"


def check_held(path: Path) -> None:
    """Read every keyframe; raise ``DamageError`` or ``StoreError`` for what cannot be used."""
    with contextlib.closing(Journal(path, open_to_read(path, SCHEMA))) as journal:
        caller_of(journal)
        for _ in journal.entries(max(journal.span()[0] - 1, 0)):
            pass
        journal.check_pages()


def delete_held(path: Path) -> None:
    """Delete a file with what a visit held, and what belongs to it."""
    for one in _parts(path):
        one.unlink(missing_ok=True)


def copy_held(path: Path, folder: Path) -> None:
    """Copy a file that nobody writes to; what is not in it yet, but in its log, comes along."""
    for one in (path.with_name(path.name + COMPANIONS[0]), path):
        if one.exists():
            shutil.copy2(one, folder)


def put_away(path: Path, error: Exception) -> None:
    """Keep a file that cannot be read out of everybody's way."""
    try:
        set_aside(path, str(error))
        delete_held(path)
    except OSError as failure:
        log.warning("%s: %s", path, failure)


def _parts(path: Path) -> Iterator[Path]:
    yield path
    yield from (path.with_name(path.name + companion) for companion in COMPANIONS)
    yield path.with_name(lock_name(path))


def lock_name(path: Path) -> str:
    """Return the name of the lock of a file."""
    return f"{path.stem}.lock"


def note_caller(journal: Journal, caller: Caller) -> None:
    """Write into a file whose it is."""
    for name in NUMBERS:
        journal.note(name, getattr(caller, name))


def caller_of(journal: Journal) -> Caller:
    """Return whose file it is; raise ``DamageError`` if it is nobody's."""
    named = NAME.fullmatch(journal.path.name)
    numbers = {name: journal.number(name, -1) for name in NUMBERS}
    if named is None or numbers["seq"] < 0:
        raise DamageError("it does not say whose keyframes these are")
    return Caller(named["robot"], **numbers)
