"""The synthetic benchmark: rooms of all kinds, some to tune on and others to test on."""

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from sceneq_core.checks import need_at_least, need_positive
from sceneq_tools.errors import UserError
from sceneq_tools.progress import progress
from sceneq_tools.room.truth.recording_files import NAMES
from sceneq_tools.synth import SynthParams

SCHEMA = "sceneq.suite.v1"
SUITE_FILE, ROOM_FILE = "suite.json", "room.json"
TUNING, TEST = "tuning", "test"
FRAME_ENDS = ("color.jpg", "depth.png", "pose.txt", "instance.png", "mask.png")
GENERATOR = ("room/**/*.py", "room/**/*.yaml", "synth.py")
"""What decides how a room looks, relative to this package."""


@dataclass(frozen=True, slots=True)
class SuiteRoom:
    """A room of the suite; ``split`` says what its recording may be used for."""

    split: str
    kind: str
    seed: int

    @property
    def name(self) -> str:
        """The folder of its recording."""
        return f"{self.split}_{self.kind}_{self.seed}"


TUNED = ("kitchen", "living_room", "office", "bedroom")
TESTED = ("kitchen", "living_room", "office", "mixed")
ROOMS = (
    *(SuiteRoom(TUNING, kind, 11) for kind in TUNED),
    *(SuiteRoom(TEST, kind, 21) for kind in TESTED),
)
"""No seed is in both splits, and one kind of room is never tuned on."""
MOST_ROUNDS = 9


def rooms_of(rounds: int) -> tuple[SuiteRoom, ...]:
    """Return ``ROOMS``, and for each further round as many of the next seeds, bedrooms tested too.

    Probabilities need many questions to be judged by; a mapper does not.

    Raises:
        ValueError: less than one round, or so many that the splits would share a seed.
    """
    if not 1 <= rounds <= MOST_ROUNDS:
        raise ValueError(f"rounds: expected 1 to {MOST_ROUNDS}, got {rounds}")
    more = [
        SuiteRoom(split, kind, first + later)
        for split, first, kinds in ((TUNING, 11, TUNED), (TEST, 21, (*TESTED, "bedroom")))
        for later in range(1, rounds)
        for kind in kinds
    ]
    return (*ROOMS, *more)


@dataclass(frozen=True, slots=True)
class SuiteParams:
    """How every room is recorded.

    Attributes:
        frames: in each room.
        rate_hz: frames a second: slow, so that few frames see the whole room.
        size: image (width, height), pixels.
        every: each so-manieth frame is a keyframe; with the rate this is one a second, as of a
            usual recording at 10 Hz.
    """

    frames: int = 60
    rate_hz: float = 2.0
    size: tuple[int, int] = (640, 480)
    every: int = 2

    def __post_init__(self) -> None:
        need_at_least(self, 1, "frames", "every")
        need_positive(self, "rate_hz")

    def of(self, room: SuiteRoom) -> SynthParams:
        """Return how one room is recorded; raise ``ValueError`` when that is impossible."""
        return SynthParams(room.seed, room.kind, self.frames, self.rate_hz, self.size)


Make = Callable[[SynthParams, Path], object]
"""Writes one recording into a folder."""


def make_suite(
    out: Path,
    params: SuiteParams,
    library: str,
    make: Make,
    quiet: bool = False,
    rooms: Sequence[SuiteRoom] = ROOMS,
) -> int:
    """Make the rooms that are not there yet, then suite.json; return how many were made.

    A room is there when its folder is complete and was made with the same parameters from the
    models of the same ``library``.

    Raises:
        ValueError: a recording that is impossible.
        OSError: a folder that cannot be written.
    """
    generator()
    (out / SUITE_FILE).unlink(missing_ok=True)
    made = 0
    with progress("rooms", len(rooms), "rooms", quiet) as advance:
        for room in rooms:
            made += _make_room(out / room.name, params.of(room), library, make)
            advance()
    document = {
        "schema": SCHEMA,
        "frames": params.frames,
        "rate_hz": params.rate_hz,
        "size": list(params.size),
        "every": params.every,
        "rooms": [{**asdict(room), **_read_json(out / room.name / ROOM_FILE)} for room in rooms],
    }
    (out / SUITE_FILE).write_text(json.dumps(document, indent=1) + "\n")
    return made


def _make_room(folder: Path, params: SynthParams, library: str, make: Make) -> bool:
    """Make a room unless it is there; tell whether it was made."""
    wanted = {"library": library, "params": json.loads(json.dumps(asdict(params)))}
    if _is_complete(folder, params.frames):
        found = _read_json(folder / ROOM_FILE)
        if {name: found.get(name) for name in wanted} == wanted:
            return False
    (folder / ROOM_FILE).unlink(missing_ok=True)
    make(params, folder)
    record = {"folder": folder.name, "generator": generator(), **wanted}
    (folder / ROOM_FILE).write_text(json.dumps(record, indent=1) + "\n")
    return True


@cache
def generator() -> str:
    """Return version and digest of what makes rooms: one generator, one picture of a seed.

    It is as it was when first asked for: what is written over it later does not run here.
    """
    package, digest = Path(__file__).parent, hashlib.sha256()
    for pattern in GENERATOR:
        for path in sorted(package.glob(pattern)):
            digest.update(str(path.relative_to(package)).encode() + path.read_bytes())
    return f"sceneq {version('sceneq')} ({digest.hexdigest()[:12]})"


def is_suite(folder: Path) -> bool:
    """Tell whether ``folder`` holds rooms of a suite."""
    return (folder / SUITE_FILE).is_file()


def read_suite(folder: Path) -> dict[str, Any]:
    """Return the content of suite.json.

    Raises:
        UserError: it is malformed, of another version, or one of its rooms is not complete.
    """
    path = folder / SUITE_FILE
    document = _read_json(path)
    if document.get("schema") != SCHEMA:
        raise UserError(f"{path}: schema {document.get('schema')!r}, expected {SCHEMA!r}", 2)
    try:
        for room in document["rooms"]:
            if not _is_complete(folder / room["folder"], document["frames"]):
                hint = "make it again: sceneq synth FOLDER --suite"
                raise UserError(f"{folder / room['folder']}: not complete ({hint})", 2)
            _need_fields(room, "split", "kind", "seed", "generator", "library")
        _need_fields(document, "every")
    except (KeyError, TypeError) as error:
        raise UserError(f"{path}: no field {error.args[0]!r}", 2) from error
    return document


def _need_fields(record: Mapping[str, Any], *names: str) -> None:
    for name in names:
        if name not in record:
            raise KeyError(name)


def _is_complete(folder: Path, frames: int) -> bool:
    per_frame = (f"frame-{n:06d}.{end}" for n in range(frames) for end in FRAME_ENDS)
    there = {path.name for path in folder.iterdir()} if folder.is_dir() else set()
    return there.issuperset((*NAMES, ROOM_FILE, *per_frame))


def _read_json(path: Path) -> dict[str, Any]:
    try:
        document = json.loads(path.read_text())
    except OSError as error:
        raise UserError(f"{path}: {error.strerror}", 2) from error
    except ValueError as error:
        raise UserError(f"{path}: no JSON: {error}", 2) from error
    if not isinstance(document, dict):
        raise UserError(f"{path}: expected an object, got {type(document).__name__}", 2)
    return document
