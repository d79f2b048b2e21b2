"""Keyframes of a visit whose place in the scene is not known yet, in a file, oldest first.

The file is the visit's submap: it names the visit, a keyframe that is in it outlives kill -9, and
it leaves only when the map has it. Without a store it lies among the temporary files.
"""

import contextlib
import logging
import re
import shutil
import tempfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.ingestor import Ingested
from sceneq_core.places.visit import Visit
from sceneq_nodes._database import open_to_read
from sceneq_nodes._folder_lock import FolderLock
from sceneq_nodes._images import frame_from_message, frame_message
from sceneq_nodes._journal import SCHEMA, Entry, Journal
from sceneq_nodes._set_aside import COMPANIONS, DamageError, StoreError, set_aside
from sceneq_nodes._wire import from_bytes, to_bytes
from sceneq_schemas.topics import FRAME

log = logging.getLogger(__name__)

NAME = re.compile(r"held-(?P<robot>[a-z0-9_-]+)-[0-9a-f]{8}\.sqlite")
NUMBERS = ("stamp_ns", "fingerprint", "seq")
"""The last one noted, and never negative, tells that all are there."""
POSE_BYTES = 16 * 8


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


class HeldFrames:
    """A queue on disk of ``most`` keyframes; one more, and the oldest is let go.

    Attributes:
        path: the file; nobody else uses it until ``close``.
        caller: whose keyframes these are.
        oldest_seq, newest_seq: numbers of the oldest one it began with and of the newest, or -1.
    """

    def __init__(self, path: Path, most: int, caller: Caller | None = None) -> None:
        """Open the file, and make it when it is to be that of ``caller``.

        Raises:
            StoreError: in use, or the disk fails.
            DamageError: no such file of ours, or damaged.
        """
        self.path, self._most = path, most
        self._temporary: tempfile.TemporaryDirectory[str] | None = None
        with contextlib.ExitStack() as opened:
            self._lock = FolderLock(path.parent, _lock_name(path))
            opened.callback(self._lock.close)
            self._journal = Journal(path)
            opened.callback(self._journal.close)
            if caller is not None:
                _note(self._journal, caller)
            self.caller = _caller(self._journal)
            first, last = self._journal.span()
            self._first, self._last = first or 1, last
            self.oldest_seq, self.newest_seq = self._seq(self._first), self._seq(self._last)
            opened.pop_all()  # all is well: they stay open
        self._done: set[int] = set()

    def __len__(self) -> int:
        """Return how many wait."""
        return self._last - self._first + 1

    @property
    def last(self) -> int:
        """Return the position of the newest keyframe; positions count from 1."""
        return self._last

    @property
    def is_durable(self) -> bool:
        """Whether they outlive this process."""
        return self._temporary is None

    def add(self, frame: Ingested) -> bool:
        """Put a keyframe behind the others; tell whether the oldest was let go for it.

        Raises:
            StoreError: the disk fails.
        """
        assert frame.keyframe is not None
        message = to_bytes(FRAME, frame_message(frame.keyframe, "raw", "raw"))
        poses = _pose_bytes(frame)
        entry = Entry(self._last + 1, frame.pose_source, message, poses, frame.seq)
        self._journal.append(entry)
        self._last, self.newest_seq = entry.position, frame.seq
        is_full = len(self) > self._most
        if is_full:
            self._drop(self._first)
        return is_full

    def read(self, after: int) -> tuple[int, Ingested] | None:
        """Return the keyframe behind position ``after`` with its position.

        Raises:
            StoreError, DamageError, DecodeError: it cannot be read.
        """
        entry = next(self._journal.entries(max(after, self._first - 1)), None)
        if entry is None:
            return None
        frame = frame_from_message(from_bytes(FRAME, entry.first))
        poses = _poses(entry.second)
        pose = frame.T_world_camera
        return entry.position, Ingested(frame.seq, frame.stamp_ns, pose, entry.kind, frame, poses)

    def forget(self, position: int) -> None:
        """Let go of a keyframe that is in the map; raise ``StoreError`` when the disk fails."""
        if position < self._first:
            return
        self._done.add(position)
        last = self._first - 1
        while last + 1 in self._done:
            last += 1
        if last >= self._first:
            self._drop(last)

    def close(self) -> None:
        """Let others have the file; delete it when nothing in it waits any more."""
        self._journal.close()
        if not len(self) or not self.is_durable:
            delete_held(self.path)
        self._lock.close()
        if self._temporary is not None:
            self._temporary.cleanup()

    def _drop(self, last: int) -> None:
        self._journal.drop(last)
        self._first = last + 1
        self._done = {position for position in self._done if position > last}

    def _seq(self, position: int) -> int:
        entry = next(self._journal.entries(position - 1), None) if position else None
        return -1 if entry is None else entry.told

    @classmethod
    def of(cls, caller: Caller, folder: Path | None, most: int) -> "HeldFrames":
        """Return those of ``caller`` in ``folder``, or, if that fails or is none, temporary ones.

        Raises:
            StoreError: not even those.
        """
        try:
            if folder is not None:
                return cls._sound(folder / caller.file_name, most, caller)
        except (StoreError, DamageError, OSError) as error:
            log.warning("%s; keyframes wait among the temporary files", error)
        temporary = tempfile.TemporaryDirectory(prefix="sceneq-held-")
        held = cls(Path(temporary.name) / caller.file_name, most, caller)
        held._temporary = temporary
        return held

    @classmethod
    def _sound(cls, path: Path, most: int, caller: Caller) -> "HeldFrames":
        try:
            return cls(path, most, caller)
        except DamageError as damage:
            set_aside(path, str(damage))
            return cls(path, most, caller)


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
        return Waiting(_caller(journal), last - first + 1 if last else 0, path)


def waiting_text(visits: int, keyframes: int) -> str:
    """Return how much waits for its place in words, empty when nothing does."""
    if not visits:
        return ""
    return f"{visits} visit{'s' * (visits > 1)} not placed, {keyframes} keyframes"


def check_held(path: Path) -> None:
    """Read every keyframe; raise ``DamageError`` or ``StoreError`` for what cannot be used."""
    with contextlib.closing(Journal(path, open_to_read(path, SCHEMA))) as journal:
        _caller(journal)
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
    yield path.with_name(_lock_name(path))


def _lock_name(path: Path) -> str:
    return f"{path.stem}.lock"


def _note(journal: Journal, caller: Caller) -> None:
    for name in NUMBERS:
        journal.note(name, getattr(caller, name))


def _caller(journal: Journal) -> Caller:
    named = NAME.fullmatch(journal.path.name)
    numbers = {name: journal.number(name, -1) for name in NUMBERS}
    if named is None or numbers["seq"] < 0:
        raise DamageError("it does not say whose keyframes these are")
    return Caller(named["robot"], **numbers)


def _pose_bytes(frame: Ingested) -> bytes:
    if not frame.corrected:
        return b""
    seqs = np.array(list(frame.corrected), "<i8")
    return seqs.tobytes() + np.stack(list(frame.corrected.values())).astype("<f8").tobytes()


def _poses(data: bytes) -> dict[int, Float64]:
    count = len(data) // (8 + POSE_BYTES)
    seqs = np.frombuffer(data, "<i8", count).tolist()
    poses = np.frombuffer(data, "<f8", 16 * count, 8 * count).reshape(count, 4, 4)
    return dict(zip(seqs, poses.astype(np.float64), strict=True))
