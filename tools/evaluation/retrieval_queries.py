"""The questions about a recording and their right answers: its ``queries.json``."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.true_things import THINGS_FILE, TrueThing, read_things

QUERIES_FILE = "queries.json"
ABSENT = "absent"
BUCKETS = ("category", "attribute", "spatial", "affordance", ABSENT)


@dataclass(frozen=True, slots=True)
class Query:
    """A question; any thing of ``targets`` (ids) is right, none at all means it is absent."""

    text: str
    bucket: str
    targets: frozenset[int]

    @property
    def is_absent(self) -> bool:
        """Whether the right answer is that there is no such thing."""
        return not self.targets


@dataclass(frozen=True, slots=True)
class Questioned:
    """A recording with truth: its things, the questions, and the digest of both."""

    folder: Path
    things: tuple[TrueThing, ...]
    queries: tuple[Query, ...]
    sha256: str

    @property
    def name(self) -> str:
        """What the folder is called."""
        return self.folder.resolve().name


def read_questioned(path: Path) -> Questioned:
    """Return what is asked about a recording; ``path`` is its folder, or questions in it.

    Raises:
        UserError: a file that is missing or malformed, or a target that is no thing.
    """
    file = path if path.is_file() else path / QUERIES_FILE
    folder = file.parent
    things = read_things(folder / THINGS_FILE)
    records = _records(file)
    ids = {name: thing.id for thing in things for name in (thing.name, str(thing.id))}
    queries = [_query(file, place, record, ids) for place, record in enumerate(records)]
    digest = hashlib.sha256((folder / THINGS_FILE).read_bytes() + file.read_bytes()).hexdigest()
    return Questioned(folder, things, tuple(queries), digest)


def _records(path: Path) -> Sequence[Mapping[str, Any]]:
    try:
        records = json.loads(path.read_text())["queries"]
    except OSError as error:
        raise UserError(f"{path}: {error.strerror}", 2) from error
    except (ValueError, KeyError, TypeError) as error:
        raise UserError(f"{path}: no list 'queries': {error!r:.80}", 2) from error
    if not isinstance(records, list):
        raise UserError(f"{path}: queries: expected a list, got {type(records).__name__}", 2)
    return records


def _query(path: Path, place: int, record: Mapping[str, Any], ids: Mapping[str, int]) -> Query:
    where = f"{path}: queries[{place}]"
    try:
        text, bucket = str(record["text"]), str(record["bucket"])
        targets = frozenset(ids[str(target)] for target in record["targets"])
    except KeyError as error:
        known = error.args[0] in ("text", "bucket", "targets")
        problem = f"no field {error.args[0]!r}" if known else f"no thing {error.args[0]!r}"
        raise UserError(f"{where}: {problem} ({THINGS_FILE} names the things)", 2) from error
    except TypeError as error:
        raise UserError(f"{where}: {error}", 2) from error
    if bool(targets) == (bucket == ABSENT):
        raise UserError(f"{where}: targets: a question has none exactly if it is 'absent'", 2)
    return Query(text, bucket, targets)
