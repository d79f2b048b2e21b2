"""The names of a scene: in memory, on disk, and in every snapshot that questions are answered from.

Requests come on pool threads, changes of the map on the node's own: one lock holds them apart.
"""

import logging
from collections.abc import Iterable, Sequence
from threading import RLock

from sceneq_core.mapping.delta import Instance
from sceneq_core.routing.scene import SceneSnapshot
from sceneq_core.teaching.album import Album
from sceneq_core.teaching.book import BookParams, Held, NameBook
from sceneq_core.teaching.reading import names_in, with_names
from sceneq_core.teaching.taught import Taught
from sceneq_nodes._bus import Bus
from sceneq_nodes._name_store import NameStore

log = logging.getLogger(__name__)


class NameKeeper:
    """Owns book and store. ``leading`` is the encoder whose vectors find things again."""

    def __init__(self, bus: Bus, params: BookParams, leading: str) -> None:
        self.leading = leading
        self.lock = RLock()
        self._bus = bus
        self._book = NameBook(params)
        self._store = NameStore(bus.context.store)
        self._recall()

    @property
    def keeps(self) -> bool:
        """Whether names outlive this process."""
        return self._store.keeps

    @property
    def problem(self) -> str:
        """What is wrong with the file of names, "" = nothing."""
        return self._store.problem

    def status(self) -> dict[str, int]:
        """Return how many names there are, and how many have lost their instance."""
        taught = self._book.taught
        lost = sum(self._book.held(one) is None for one in taught)
        return {"taught": len(taught), "unattached": lost}

    @property
    def taught(self) -> tuple[Taught, ...]:
        """All names, the oldest first."""
        return self._book.taught

    @property
    def next_number(self) -> int:
        """The number of the next name."""
        return self._book.next_number

    def held(self, one: Taught) -> Held | None:
        """Return the instance that a name is of now."""
        return self._book.held(one)

    def find(self, name: str) -> tuple[Taught, ...]:
        """Return what was taught with these words."""
        return self._book.called(name)

    def names_of(self, instance_id: int) -> tuple[Taught, ...]:
        """Return the names that an instance has."""
        return self._book.names_of(instance_id)

    def teach(self, one: Taught) -> tuple[Taught, ...]:
        """Give a name; return those that it replaces. Call it with the lock held.

        Raises:
            ValueError: there are too many.
            OSError: it cannot be written; then nothing has changed.
        """
        replaced = self._book.replaced_by(one)
        self._store.write(taught=[one], forgotten=replaced)
        self._book.teach(one)
        return replaced

    def forget(self, names: Sequence[Taught]) -> None:
        """Take names back. Call it with the lock held; raises ``OSError`` as ``teach``."""
        self._store.write(forgotten=names)
        self._book.forget(names)

    def follow(self, map_epoch: int, instances: Iterable[Instance]) -> None:
        """Stick to what an instance was merged into."""
        with self.lock:
            self._book.follow(map_epoch, instances)

    def named(self, bare: SceneSnapshot, album: Album) -> SceneSnapshot:
        """Return a snapshot in which things are called what they were taught."""
        with self.lock:
            if album.model_id == self.leading:
                self._book.settle(bare, album)
                self._note()
            return with_names(bare, names_in(bare, self._book, album))

    def _note(self) -> None:
        """Write down where names have moved; without it they are searched for at the next start."""
        moved, anew = self._book.take_moved(), self._book.take_seen_anew()
        try:
            self._store.write(moved=moved, taught=anew)
        except OSError as error:
            changes = len(moved) + len(anew)
            self._bus.count("names_not_written", changes)
            log.error("names: %s; %d changes are in memory only", error, changes)

    def _recall(self) -> None:
        """Know again what was taught before this process was started."""
        try:
            names = self._store.read()
        except (OSError, ValueError) as error:
            self._store.give_up(f"the names on disk cannot be used: {error}")
            names = ()
        if self.problem:
            self._bus.count("names_damaged")
        for one in names:
            self._book.recall(one)
