"""Durable files that cannot be used: damaged ones are put aside, newer ones left alone."""

import itertools
import logging
import os
from pathlib import Path

log = logging.getLogger(__name__)

SUFFIX = ".corrupt"
COMPANIONS = ("-wal", "-shm")
"""What SQLite keeps beside a database."""


class StoreError(Exception):
    """Why durable files cannot be used; nothing on disk has been changed."""


class NewerSchemaError(StoreError):
    """Written by a later version of this program."""

    def __init__(self, path: Path, found: int, known: int, what: str = "schema") -> None:
        super().__init__(f"{path}: {what} {found}, this version knows {known} at most")


class DamageError(Exception):
    """A file that is torn or changed: what is wrong with it, without its name."""


def set_aside(path: Path, reason: str) -> Path:
    """Rename a damaged file, and what belongs to it, out of the way; return its new name.

    Raises:
        OSError: the folder cannot be written.
    """
    kept = free_name(path)
    log.error("%s: %s; set aside as %s", path, reason, kept.name)
    path.rename(kept)
    for companion in COMPANIONS:
        beside = path.with_name(path.name + companion)
        if beside.exists():
            beside.rename(kept.with_name(kept.name + companion))
    return kept


def free_name(path: Path) -> Path:
    """Return the first name for a damaged file that nothing has."""
    names = (f"{path.name}{SUFFIX}{number or ''}" for number in itertools.count())
    return next(p for name in names if not (p := path.with_name(name)).exists())


def sync_folder(folder: Path) -> None:
    """Make new and renamed files of a folder outlive a power cut."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
