"""The things of a rendered recording: its ``instances.json``."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.vocabulary import Names

THINGS_FILE = "instances.json"


@dataclass(frozen=True, slots=True)
class TrueThing:
    """A thing as it is at one moment of its recording, if not said otherwise at the end.

    Attributes:
        id: what instance.png says where it is seen.
        name: as questions name it.
        names: its label, then its synonyms.
        is_stuff: wall or floor: no object.
        since_frame: the frame from which on it stands where it stands then; ``None`` = it is not
            there.
        affordances: what it is good for, as far as the recording says.
    """

    id: int
    name: str
    names: Names
    is_stuff: bool
    since_frame: int | None
    affordances: tuple[str, ...] = ()


def read_things(path: Path, before_frame: int | None = None) -> tuple[TrueThing, ...]:
    """Return the things of a recording, by id, as they were just before a frame or at the end.

    Raises:
        UserError: no such file, or a record without one of its fields.
    """
    try:
        records = json.loads(path.read_text())["instances"]
    except OSError as error:
        raise UserError(f"{path}: {error.strerror}", 2) from error
    except (ValueError, KeyError, TypeError) as error:
        raise UserError(f"{path}: no list 'instances': {error!r:.80}", 2) from error
    things = [_thing(path, place, one, before_frame) for place, one in enumerate(records)]
    return tuple(sorted(things, key=lambda thing: thing.id))


def _thing(
    path: Path, place: int, record: Mapping[str, Any], before_frame: int | None
) -> TrueThing:
    try:
        last = _last_stay(record["history"], before_frame)
        return TrueThing(
            id=int(record["id"]),
            name=str(record["name"]),
            names=(str(record["label"]), *map(str, record.get("synonyms", ()))),
            is_stuff=bool(record["stuff"]),
            since_frame=None if last["box"] is None else int(last["from_frame"]),
            affordances=tuple(map(str, record.get("affordances", ()))),
        )
    except KeyError as error:
        raise UserError(f"{path}: instances[{place}]: no field {error.args[0]!r}", 2) from error
    except (TypeError, ValueError, IndexError, AttributeError) as error:
        raise UserError(f"{path}: instances[{place}]: {error}", 2) from error


def _last_stay(history: list[Any], before_frame: int | None) -> Mapping[str, Any]:
    """Return where a thing was just before a frame, or at the end."""
    if before_frame is None:
        return dict(history[-1])
    until = [stay for stay in history if int(stay["from_frame"]) < before_frame]
    return dict(until[-1]) if until else {"from_frame": 0, "box": None}
