"""Keyframes of a visit whose place in the scene is not known yet, in a file, oldest first.

The file is the visit's submap: it names the visit, a keyframe that is in it outlives kill -9, and
it leaves only when the map has it. Without a store it lies among the temporary files.
"""

import contextlib
import logging
import tempfile
from pathlib import Path

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.ingestor import Ingested
from sceneq_nodes._folder_lock import FolderLock
from sceneq_nodes._held_files import Caller, caller_of, delete_held, lock_name, note_caller
from sceneq_nodes._images import frame_from_message, frame_message
from sceneq_nodes._journal import Entry, Journal
from sceneq_nodes._set_aside import DamageError, StoreError, set_aside
from sceneq_nodes._wire import from_bytes, to_bytes
from sceneq_schemas.topics import FRAME

log = logging.getLogger(__name__)

POSE_BYTES = 16 * 8


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
            self._lock = _locked(path)
            opened.callback(self._lock.close)
            self._journal = Journal(path)
            opened.callback(self._journal.close)
            if caller is not None:
                note_caller(self._journal, caller)
            self.caller = caller_of(self._journal)
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
        try:
            if not len(self) or not self.is_durable:
                delete_held(self.path)
        except OSError as error:
            log.warning("%s: %s", self.path, error)
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
                folder.mkdir(mode=0o700, parents=True, exist_ok=True)
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


def _locked(path: Path) -> FolderLock:
    try:
        return FolderLock(path.parent, lock_name(path))
    except OSError as error:
        raise StoreError(f"{path}: {error.strerror or error}") from error


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
