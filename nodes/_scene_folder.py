"""The durable files of one scene, looked at, checked and tidied while no node uses them."""

import contextlib
import json
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from sceneq_core.places.visit import Visit, Visits
from sceneq_core.state import build
from sceneq_nodes._checkpoints import Checkpoint, Checkpoints, read
from sceneq_nodes._database import check_pages, damage_named, open_to_read
from sceneq_nodes._folder_lock import FolderLock
from sceneq_nodes._held_files import Waiting, check_held, delete_held, held_files, waiting_in
from sceneq_nodes._item_store import SCHEMA as ITEMS_SCHEMA
from sceneq_nodes._item_store import damaged_items
from sceneq_nodes._journal import SCHEMA as JOURNAL_SCHEMA
from sceneq_nodes._journal import Entry, Journal
from sceneq_nodes._kept_deltas import FILE as TOLD
from sceneq_nodes._map_store import FOLDER, JOURNAL
from sceneq_nodes._mapped import VISITED
from sceneq_nodes._set_aside import SUFFIX, DamageError, StoreError
from sceneq_nodes._visit_json import visit_from_json

VIEWS, FEATURES = "views.sqlite", "features-*.sqlite"


@dataclass(frozen=True, slots=True)
class SceneFacts:
    """What there is: ``position`` counts what entered the map, from ``first`` on it is kept.

    ``waiting_keyframes`` of ``waiting_visits`` are not in the map: nobody knows where they belong.
    """

    name: str
    size_bytes: int
    position: int
    first: int
    checkpoints: tuple[int, ...]
    keyframes: int
    described: dict[str, int]
    set_aside: tuple[str, ...]
    is_in_use: bool
    waiting_visits: int = 0
    waiting_keyframes: int = 0


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether a file can be used; ``problem`` is empty when it can."""

    file: str
    problem: str


class SceneFolder:
    """The folder of a scene; ``find`` makes sure that it is one."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._map = path / FOLDER

    def facts(self) -> SceneFacts:
        """Return what there is; raise ``StoreError`` when it cannot be read."""
        first, last = self._span()
        positions = tuple(checkpoint.position for checkpoint in self._checkpoints())
        models = {_model(path): _count(path, "instance") for path in self._feature_files()}
        views, waiting = self.path / VIEWS, self.waiting()
        return SceneFacts(
            name=self.path.name,
            size_bytes=sum(path.stat().st_size for path in self._files()),
            position=max((last, *positions)),
            first=first,
            checkpoints=positions,
            keyframes=_count(views, "keyframe") if views.exists() else 0,
            described=models,
            set_aside=tuple(sorted(path.name for path in self._set_aside())),
            is_in_use=self._is_in_use(),
            waiting_visits=len(waiting),
            waiting_keyframes=sum(one.keyframes for one in waiting),
        )

    def waiting(self) -> list[Waiting]:
        """Return what visits hold that is not in the map; raise ``StoreError``."""
        found: list[Waiting] = []
        for path in held_files(self.path):
            with _named(path):
                found += waiting_in(path)
        return found

    def drop(self, waiting: Waiting) -> None:
        """Delete what a visit holds; raise ``StoreError`` while the scene is in use."""
        with self.locked():
            delete_held(waiting.path)

    def verify(self) -> Iterator[Verdict]:
        """Read everything, and yield what comes of each file."""
        for checkpoint in self._checkpoints():
            yield _verdict(self.path, checkpoint.path, partial(read, checkpoint))
        if self._journal_path.exists():
            yield _verdict(self.path, self._journal_path, self._read_journal)
        for path in self._item_files():
            if path.exists():
                yield _verdict(self.path, path, partial(_read_items, path))
        for path in held_files(self.path):
            yield _verdict(self.path, path, partial(check_held, path))

    def compact(self) -> None:
        """Keep the newest checkpoint that can be read and what came after it, nothing older.

        Raises:
            StoreError: in use, or nothing there can be read.
        """
        with self.locked():
            self._compact_map()
            for path in self._item_files():
                if path.exists():
                    _vacuum(path, ITEMS_SCHEMA)
            for path in self._set_aside():
                path.unlink()

    def delete(self) -> None:
        """Delete the folder with all that is in it; raise ``StoreError`` while it is in use."""
        with self.locked():
            shutil.rmtree(self.path)

    @contextlib.contextmanager
    def locked(self) -> Iterator[None]:
        """Keep every writer out; raise ``StoreError`` when there is one."""
        with contextlib.ExitStack() as held:
            for path in self.path.rglob("*lock"):
                held.enter_context(contextlib.closing(FolderLock(path.parent, path.name)))
            yield

    def visits(self) -> list[Visit]:
        """Return who came into the scene; raise ``StoreError`` when that cannot be read."""
        visits = Visits()
        for checkpoint in self._checkpoints()[:1]:
            with _named(checkpoint.path):
                _, beside = build(read(checkpoint))
                for told in json.loads(beside.get("visits", "[]")):
                    visits.take(visit_from_json(told))
        if self._journal_path.exists():
            with _named(self._journal_path), contextlib.closing(self._journal()) as journal:
                for entry in journal.of_kind(VISITED):
                    visits.take(visit_from_json(json.loads(entry.first)))
        return visits.all()

    def entries(self) -> Iterator[Entry]:
        """Yield all that is kept of how the map came about; raise ``StoreError`` where damaged."""
        with _named(self._journal_path), contextlib.closing(self._journal()) as journal:
            first, _ = journal.span()
            yield from journal.entries(max(first - 1, 0))

    @property
    def _journal_path(self) -> Path:
        return self._map / JOURNAL

    def _compact_map(self) -> None:
        for checkpoint in self._checkpoints():
            with contextlib.suppress(DamageError):
                read(checkpoint)
                break
        else:
            return  # without a checkpoint every entry is needed
        with contextlib.closing(Journal(self._journal_path)) as journal:
            while 0 < journal.span()[0] <= checkpoint.position:
                journal.drop_some(checkpoint.position)
        _vacuum(self._journal_path, JOURNAL_SCHEMA)
        for other in self._checkpoints():
            if other != checkpoint:
                other.path.unlink()

    def _checkpoints(self) -> list[Checkpoint]:
        return Checkpoints(self._map).newest_first() if self._map.is_dir() else []

    def _feature_files(self) -> list[Path]:
        return sorted(self.path.glob(FEATURES))

    def _item_files(self) -> list[Path]:
        return [self._map / TOLD, self.path / VIEWS, *self._feature_files()]

    def _files(self) -> Iterator[Path]:
        return (path for path in self.path.rglob("*") if path.is_file())

    def _set_aside(self) -> list[Path]:
        return [path for path in self._files() if SUFFIX in path.name]

    def _span(self) -> tuple[int, int]:
        if not self._journal_path.exists():
            return 0, 0
        with _named(self._journal_path), contextlib.closing(self._journal()) as journal:
            return journal.span()

    def _journal(self) -> Journal:
        return Journal(self._journal_path, open_to_read(self._journal_path, JOURNAL_SCHEMA))

    def _read_journal(self) -> None:
        with contextlib.closing(self._journal()) as journal:
            first, _ = journal.span()
            for _ in journal.entries(max(first - 1, 0)):
                pass
            journal.check_pages()

    def _is_in_use(self) -> bool:
        try:
            with self.locked():
                return False
        except StoreError:
            return True


def find(store: Path) -> list[SceneFolder]:
    """Return the scenes in ``store``, by name; raise ``StoreError`` without such a folder."""
    if not store.is_dir():
        raise StoreError(f"{store}: no such folder")
    return [SceneFolder(path) for path in sorted(store.iterdir()) if _is_scene(path)]


def _is_scene(path: Path) -> bool:
    is_kept = (path / FOLDER).is_dir() or (path / VIEWS).is_file()
    return is_kept or any(path.glob(FEATURES)) or bool(held_files(path))


@contextlib.contextmanager
def _named(path: Path) -> Iterator[None]:
    """Name the file in what is wrong with it."""
    try:
        yield
    except (DamageError, StoreError, OSError) as error:
        told = str(error) if str(path) in str(error) else f"{path}: {error}"
        raise StoreError(told) from error


def _verdict(folder: Path, path: Path, reading: Callable[[], object]) -> Verdict:
    try:
        reading()
    except (DamageError, StoreError, OSError) as error:
        return Verdict(str(path.relative_to(folder)), str(error))
    return Verdict(str(path.relative_to(folder)), "")


def _model(path: Path) -> str:
    return path.stem.partition("-")[2]


def _count(path: Path, kind: str) -> int:
    with _named(path), contextlib.closing(open_to_read(path, ITEMS_SCHEMA)) as db, damage_named():
        return int(db.execute("SELECT count(*) FROM item WHERE kind = ?", (kind,)).fetchone()[0])


def _read_items(path: Path) -> None:
    with contextlib.closing(open_to_read(path, ITEMS_SCHEMA)) as db:
        check_pages(db)
        if damaged := damaged_items(db):
            raise DamageError(f"wrong checksum: {', '.join(damaged)}")


def _vacuum(path: Path, schema: int) -> None:
    """Give the room of what was deleted back to the disk."""
    connection = open_to_read(path, schema, alone=True)
    with _named(path), contextlib.closing(connection) as db, damage_named():
        db.execute("VACUUM")
