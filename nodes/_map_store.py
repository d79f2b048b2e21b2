"""Keeps a map on disk: a journal of what entered it and, now and then, all of it.

After any end of the process the map is that of the newest checkpoint with the journal's later
entries done again. What fails on the disk costs the map's durability, never the map.
"""

import logging
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sceneq_core.mapping.delta import MapDelta
from sceneq_core.state import StateError
from sceneq_nodes._checkpoint_writer import CheckpointWriter
from sceneq_nodes._checkpoints import Checkpoint, Checkpoints, read
from sceneq_nodes._database import open_to_read
from sceneq_nodes._epoch import first_seq, new_epoch
from sceneq_nodes._folder_lock import FolderLock
from sceneq_nodes._journal import SCHEMA, Entry, Journal
from sceneq_nodes._mapped import Mapped
from sceneq_nodes._set_aside import DamageError, NewerSchemaError, StoreError, set_aside
from sceneq_nodes._store_params import StoreParams
from sceneq_schemas.codec import encode

log = logging.getLogger(__name__)

FOLDER, JOURNAL = "map", "journal.sqlite"
EPOCH, RUN = "epoch", "run"


class NoStore:
    """Stands for a map in memory only."""

    first_seq = told_after = 0
    told_folder = None

    def __init__(self) -> None:
        self.epoch = new_epoch()
        self.repeated: list[tuple[int, MapDelta]] = []

    def keep(self, told: int, kind: str, *parts: Any) -> None:
        """Keep nothing."""

    def worked(self, seconds: float, told: int) -> None:
        """Write no checkpoint."""

    def close(self) -> None:
        """Nothing to release."""


class MapStore:
    """The durable side of one ``Mapped``, in ``scene_folder``/map.

    Attributes:
        epoch: the name of the map, which stays as long as it is this map.
        run: how often this map was opened before.
        told_after: number of the last delta before those of ``repeated``.
        repeated: the deltas of the entries that ``recover`` did again, with their numbers.
    """

    def __init__(
        self, scene_folder: Path, params: StoreParams, mapped: Mapped, count: Callable[[str], None]
    ) -> None:
        self.folder = scene_folder / FOLDER
        self.epoch, self.run, self.told_after = new_epoch(), 0, 0
        self.repeated: list[tuple[int, MapDelta]] = []
        self._params = params
        self._mapped = mapped
        self._count = count
        self._checkpoints = Checkpoints(self.folder)
        self._writer = CheckpointWriter(self._checkpoints, params.keep, params.share)
        self._journal: Journal | None = None
        self._lock: FolderLock | None = None
        self._position = 0
        self._worked_s = 0.0
        self._is_behind = self._is_remade = False

    @property
    def first_seq(self) -> int:
        """The number before that of the first delta of this run."""
        return first_seq(self.run)

    @property
    def told_folder(self) -> Path | None:
        """Where to keep what is told; nowhere while the map itself is not kept."""
        return None if self._is_behind else self.folder

    def recover(self) -> None:
        """Bring the map to where the last run ended.

        Raises:
            StoreError: what is there cannot be used: of a newer version, of other parameters, or
                not readable. The map is empty, and nothing on disk has been changed.
        """
        began_s = time.monotonic()
        try:
            self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            self._lock = FolderLock(self.folder)
            source = self._open_journal()
            self._position = self._restore(source)
            if source is not None:
                self._repeat(source)
            self._begin_run(source)
        except OSError as error:
            raise StoreError(f"{self.folder}: {error.strerror or error}") from error
        if self._position:
            took_s = time.monotonic() - began_s
            told = (self._position, len(self.repeated), took_s)
            log.info("map recovered: entry %d, %d deltas told again, %.1f s", *told)

    def keep(self, told: int, kind: str, *parts: Any) -> None:
        """Commit what entered the map just now, a message or two, before anybody is told.

        ``told`` is the number of the last delta before.
        """
        self._position += 1
        if self._is_behind or self._journal is None:
            return
        try:
            data = [part if isinstance(part, bytes) else encode(part) for part in parts]
            first, second = [*data, b""][:2]
            self._journal.append(Entry(self._position, kind, first, second, told))
            self._make_room(self._journal)
        except (StoreError, DamageError) as error:
            self._fall_behind(error)

    def worked(self, seconds: float, told: int) -> None:
        """Take a checkpoint when it is due, after ``seconds`` more were spent on the map."""
        self._worked_s += seconds
        self._collect()
        if self._worked_s >= self._params.replay_s and self._writer.is_free():
            self._checkpoint(told)

    def _checkpoint(self, told: int) -> None:
        """Write the whole map as of now, on another thread; stay for it while it is behind."""
        self._worked_s = 0.0
        state = self._mapped.state(epoch=self.epoch, run=self.run, told=told)
        self._writer.start(self._position, state)
        if self._is_behind:
            self._writer.wait()
            self._collect()

    def close(self) -> None:
        """Wait for the checkpoint being written, and let go of the files."""
        self._writer.wait()
        if self._journal is not None:
            self._journal.close()
        if self._lock is not None:
            self._lock.close()

    def _open_journal(self) -> Journal | None:
        """Return the journal to read, ``None`` if that is impossible; write to it if possible."""
        path = self.folder / JOURNAL
        try:
            self._journal = Journal(path)
        except NewerSchemaError:
            raise
        except StoreError as error:
            self._fall_behind(error)
        else:
            return self._journal
        try:
            return Journal(path, open_to_read(path, SCHEMA, alone=True))
        except (StoreError, DamageError) as error:
            log.error("%s: not readable: %s", path, error)
            return None

    def _restore(self, journal: Journal | None) -> int:
        """Return the position of the newest checkpoint that can be used, 0 without any."""
        for checkpoint in self._checkpoints.newest_first():
            try:
                self._take(checkpoint)
            except DamageError as damage:
                set_aside(checkpoint.path, str(damage))
                self._count("store_damaged")
            except StateError as error:
                if journal is None or journal.span()[0] != 1:
                    raise StoreError(f"{checkpoint.path}: {error}") from error
                log.warning("%s: %s; the whole journal is done again", checkpoint.path, error)
                self._is_remade = True
                return 0
            else:
                return checkpoint.position
        return 0

    def _take(self, checkpoint: Checkpoint) -> None:
        beside = self._mapped.resume(read(checkpoint))
        self.epoch, self.run = int(beside[EPOCH]), int(beside[RUN]) + 1
        self.told_after = int(beside["told"])

    def _repeat(self, journal: Journal) -> None:
        """Do the entries behind the checkpoint again, up to the first that is damaged."""
        try:
            for entry in journal.entries(self._position):
                deltas = self._mapped.repeat(entry)
                self.repeated += enumerate(deltas, entry.told + 1)
                self._position = entry.position
            self._number_on(journal)
        except (DamageError, ValueError) as damage:
            self._rename()
            self._renew_journal(journal, str(damage))

    def _number_on(self, journal: Journal) -> None:
        """Take the epoch and the run that the last one noted, if the map is the same."""
        noted = journal.number(EPOCH)
        if noted and not self._is_remade:
            self.epoch, self.run = noted, max(self.run, journal.number(RUN, -1) + 1)
        elif self._position:
            self._rename()

    def _rename(self) -> None:
        """Begin a new epoch: what readers know of the old one is no base for what comes."""
        self.epoch, self.run, self.repeated = new_epoch(), 1, []
        self.told_after = self.first_seq

    def _renew_journal(self, damaged: Journal, reason: str) -> None:
        """Go on in a new journal, with a checkpoint of what the damaged one told."""
        if damaged is not self._journal:
            return  # nothing can be written
        damaged.close()
        set_aside(damaged.path, reason)
        self._count("store_damaged")
        self._journal = Journal(damaged.path)
        self._checkpoint(first_seq(self.run + 1))
        self._writer.wait()

    def _begin_run(self, source: Journal | None) -> None:
        """Note that there was one more run; else the next could number its deltas alike."""
        if source is not None and source is not self._journal:
            source.close()
        try:
            if self._journal is not None:
                self._note_run(self._journal)
                return
        except StoreError as error:
            self._fall_behind(error)
        self._rename()

    def _note_run(self, journal: Journal) -> None:
        journal.note(EPOCH, self.epoch)
        journal.note(RUN, self.run)

    def _make_room(self, journal: Journal) -> None:
        """Let go of old entries: a few when there are too many, the rest when some are gone."""
        if not self._writer.oldest:
            return
        is_part = journal.span()[0] != 1
        if is_part or journal.used_bytes() > self._params.max_mb * 1e6:
            journal.drop_some(self._writer.oldest)

    def _fall_behind(self, error: Exception) -> None:
        self._count("store_failed")
        if not self._is_behind:
            log.error("%s; the map lives on in memory only", error)
        self._is_behind = True

    def _collect(self) -> None:
        try:
            if self._writer.finished() and self._is_behind:
                self._catch_up()
        except OSError as error:
            self._fall_behind(StoreError(f"{self.folder}: {error.strerror or error}"))

    def _catch_up(self) -> None:
        """Go on with the journal: the checkpoint just written holds what it misses."""
        try:
            self._journal = self._journal or Journal(self.folder / JOURNAL)
            self._note_run(self._journal)
        except StoreError as error:
            self._fall_behind(error)
        else:
            self._is_behind = False
            log.warning("the map is durable again")


def open_store(
    scene_folder: Path | None, params: StoreParams, mapped: Mapped, count: Callable[[str], None]
) -> MapStore | NoStore:
    """Bring ``mapped`` back from ``scene_folder`` and return what keeps it; nothing for ``None``.

    A store that cannot be used is counted (``store_failed``), told, and left alone.
    """
    if scene_folder is None:
        return NoStore()
    store = MapStore(scene_folder, params, mapped, count)
    try:
        store.recover()
    except StoreError as error:
        store.close()
        count("store_failed")
        log.error("%s; the map is made anew, in memory only", error)
        return NoStore()
    return store
