"""When a rendered room was changed, and what: from its ``instances.json``."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.true_things import THINGS_FILE


@dataclass(frozen=True, slots=True)
class History:
    """Names of things by number, where the room was changed, and which things each time."""

    names: dict[int, str]
    cuts: tuple[int, ...]
    changed: tuple[tuple[int, ...], ...]


def read_history(folder: Path) -> History:
    """Return when what was changed; ``UserError`` when the recording says nothing of it."""
    path = folder / THINGS_FILE
    try:
        document = json.loads(path.read_text())
        stays = {
            int(o["id"]): [int(s["from_frame"]) for s in o["history"]] for o in _things(document)
        }
        cuts = sorted({int(s["first"]) for s in document["segments"]} - {0})
        names = {int(one["id"]): str(one["name"]) for one in _things(document)}
    except OSError as error:
        raise UserError(f"{path}: {error.strerror}", 2) from error
    except (ValueError, KeyError, TypeError) as error:
        raise UserError(f"{path}: no list of segments and things: {error!r:.80}", 2) from error
    if not cuts:
        raise UserError(f"{path}: nothing changes in this recording", 2)
    changed = [tuple(i for i, frames in stays.items() if cut in frames) for cut in cuts]
    return History(names, tuple(cuts), tuple(changed))


def _things(document: dict[str, Any]) -> list[dict[str, Any]]:
    return [one for one in document["instances"] if not one["stuff"]]
