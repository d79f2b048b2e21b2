"""Where taught names outlive the process: ``names.jsonl``, to which lines are only ever added.

A line is on the disk before its request is answered. What a crash tore, or a disk changed, is set
aside in a copy of the file; the whole lines stay.
"""

import logging
import os
import shutil
from collections.abc import Iterable, Sequence
from pathlib import Path

from sceneq_core.teaching.taught import Taught
from sceneq_nodes._name_record import (
    ForeignError,
    Record,
    forget_record,
    line_of,
    record_of,
    replay,
    stand_record,
    teach_record,
)
from sceneq_nodes._set_aside import free_name, sync_folder

log = logging.getLogger(__name__)

FILE = "names.jsonl"
PRIVATE = 0o600
SPARE_LINES = 1000
"""The file is written anew when it has so many lines more than it needs."""


class NameStore:
    """The names of one scene on disk; nothing is kept, nor read, without a folder.

    ``problem`` says what is wrong with the file, "" = nothing.
    """

    def __init__(self, folder: Path | None) -> None:
        self._path = folder / FILE if folder else None
        self.problem = ""

    @property
    def keeps(self) -> bool:
        """Whether names outlive the process."""
        return self._path is not None

    def read(self) -> tuple[Taught, ...]:
        """Return the names on disk, by number; what is damaged is set aside, and said.

        Raises:
            OSError: the file or its folder cannot be read or written.
        """
        if self._path is None or not self._path.exists():
            return ()
        whole, records, bad = _sorted(self._path.read_bytes())
        names = replay(records)
        if bad:
            kept = _set_aside(self._path)
            self.problem = f"{len(bad)} damaged lines ({bad[0]}) set aside in {kept.name}"
            log.error("%s: %s", self._path, self.problem)
        if bad or len(whole) > 2 * len(names) + SPARE_LINES:
            self._rewrite(whole if bad else [line_of(teach_record(one)) for one in names.values()])
        return tuple(names[number] for number in sorted(names))

    def write(
        self,
        taught: Iterable[Taught] = (),
        forgotten: Iterable[Taught] = (),
        moved: Iterable[Taught] = (),
    ) -> None:
        """Add what happened, all of it or nothing; it is on the disk on return.

        Raises:
            OSError: it cannot be written.
        """
        records = [
            *map(forget_record, forgotten),
            *map(teach_record, taught),
            *map(stand_record, moved),
        ]
        if self._path is not None and records:
            _append(self._path, b"".join(map(line_of, records)))

    def give_up(self, problem: str) -> None:
        """Keep nothing from here on: the file cannot be used, and is left as it is."""
        log.error("%s: %s", self._path, problem)
        self._path, self.problem = None, problem

    def _rewrite(self, lines: Sequence[bytes]) -> None:
        """Replace the file by ``lines``; at no time is there none."""
        assert self._path is not None
        new = self._path.with_suffix(".new")
        new.unlink(missing_ok=True)
        _append(new, b"".join(lines))
        new.replace(self._path)
        sync_folder(self._path.parent)


def _sorted(data: bytes) -> tuple[list[bytes], list[Record], list[str]]:
    """Return the whole lines, the records in them and what is wrong with the others."""
    whole, records, bad = [], [], []
    for number, line in enumerate(data.splitlines(keepends=True), 1):
        try:
            if not line.endswith(b"\n"):
                raise ValueError("it ends in the middle")
            record = record_of(line)
            replay([record])
            records.append(record)
        except ForeignError as error:
            log.warning("%s, line %d: %s is left as it is", FILE, number, error)
        except ValueError as error:
            bad.append(f"line {number}: {error}")
            continue
        whole.append(line)
    return whole, records, bad


def _append(path: Path, data: bytes) -> None:
    """Add ``data``, all of it or nothing, and wait until it is on the disk."""
    is_new = not path.exists()
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, PRIVATE)
    try:
        size = os.fstat(descriptor).st_size
        try:
            written = os.write(descriptor, data)
            if written < len(data):
                raise OSError(0, f"only {written} of {len(data)} bytes could be written")
            os.fsync(descriptor)
        except OSError:
            os.ftruncate(descriptor, size)
            raise
    finally:
        os.close(descriptor)
    if is_new:
        sync_folder(path.parent)


def _set_aside(path: Path) -> Path:
    """Copy a damaged file to where nothing else is; return that."""
    kept = free_name(path)
    shutil.copyfile(path, kept)
    kept.chmod(PRIVATE)
    return kept
