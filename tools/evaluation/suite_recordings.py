"""What an evaluation of everything is about: rooms of suites, and any recordings given."""

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.rendered_truth import is_rendered
from sceneq_tools.suite import TEST, TUNING, is_suite, read_suite

GIVEN = "given"
SPLITS = (TUNING, TEST, GIVEN)


@dataclass(frozen=True, slots=True)
class Recording:
    """A recording with truth and questions.

    Attributes:
        name: unique in an evaluation.
        folder: of its files.
        split: tuning, test, or given.
        every: each so-manieth frame is a keyframe; ``None`` = as the graph says.
        made_by: what made the recording, as far as that is known.
    """

    name: str
    folder: Path
    split: str
    every: int | None = None
    made_by: str = ""


def recordings_of(folders: Iterable[Path], every: int | None = None) -> tuple[Recording, ...]:
    """Return the rooms of all suites and the recordings among ``folders``, by split.

    ``every`` replaces what a suite says about its keyframes, and what the graph says of others.

    Raises:
        UserError: a folder is neither, or two recordings have the same name.
    """
    found = [one for folder in folders for one in _recordings_in(folder, every)]
    found.sort(key=lambda one: SPLITS.index(one.split))
    names = [one.name for one in found]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise UserError(f"{twice[0]}: two recordings have this name", 2)
    return tuple(found)


def _recordings_in(folder: Path, every: int | None) -> Iterable[Recording]:
    if is_suite(folder):
        document = read_suite(folder)
        for room in document["rooms"]:
            made_by = f"{room['generator']}, {room['library']}"
            path = folder / room["folder"]
            yield Recording(path.name, path, room["split"], every or document["every"], made_by)
    elif is_rendered(folder):
        yield Recording(folder.resolve().name, folder, GIVEN, every)
    else:
        hint = "make a suite: sceneq synth FOLDER --suite"
        raise UserError(f"{folder}: neither a suite nor a recording with truth ({hint})", 2)


def frames_digest(folder: Path) -> str:
    """Return the SHA-256 of everything that a map of a recording can be made from."""
    digest = hashlib.sha256()
    for path in sorted(folder.iterdir()):
        if path.is_file() and path.suffix != ".md":
            digest.update(f"{path.name}\0{path.stat().st_size}\0".encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()
