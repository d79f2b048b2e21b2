"""From the book of names to what questions and answers see of it: the names of one snapshot."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from sceneq_core.mapping.delta import OBJECT
from sceneq_core.routing.labels import INHERITED, TAUGHT, Label
from sceneq_core.routing.names import NO_NAMES, GivenName, Names
from sceneq_core.routing.scene import SceneSnapshot
from sceneq_core.teaching.album import Album
from sceneq_core.teaching.book import NameBook
from sceneq_core.teaching.taught import Taught
from sceneq_core.teaching.wording import CATEGORY, INDIVIDUAL, spoken, thing_of

LIKE = "like "
"""What a look-alike of an individual is called at most: "like aunt Mary's mug"."""

MAX_HEIRS = 200
"""No more look-alikes inherit one name, the surest do: to an encoder all may look alike."""


def names_in(snapshot: SceneSnapshot, book: NameBook, album: Album) -> Names:
    """Return what is called how in ``snapshot``.

    Categories are inherited by look-alikes that are objects and were not taught one themselves.
    """
    album.compare_with(book.taught)
    if not book.taught:
        return NO_NAMES
    reading = _Reading(snapshot, book, album)
    for group in _by_words(book.taught):
        reading.add(group)
    return reading.names()


def _by_words(taught: Sequence[Taught]) -> list[list[Taught]]:
    """Return what was taught with the same words together, newest first."""
    groups: dict[str, list[Taught]] = {}
    for one in reversed(taught):
        groups.setdefault(spoken(one.name), []).append(one)
    return list(groups.values())


class _Reading:
    """The names of one snapshot in the making."""

    def __init__(self, snapshot: SceneSnapshot, book: NameBook, album: Album) -> None:
        self._book = book
        self._album = album
        self._find = snapshot.find
        self._ids = snapshot.columns.instance_id.astype(np.int64)
        self._is_object = snapshot.columns.role == OBJECT
        self._given: dict[str, list[GivenName]] = {}
        self._called: _Ranked = {}
        self._like: _Ranked = {}
        self._has_category = self._rows_of(CATEGORY)

    def add(self, group: list[Taught]) -> None:
        """Take in what was taught with the same words, newest first."""
        newest = group[0]
        p = self._taught(group)
        for row, held in p.items():
            rank = (0 if newest.kind == INDIVIDUAL else 1, -newest.number)
            _add(self._called, row, rank, Label(newest.name, held, 1.0, TAUGHT))
        maybe: dict[int, float] = {}
        for row, alike, cosine in self._alike(group, set(p)):
            if newest.kind == INDIVIDUAL:
                label = Label(LIKE + newest.name, alike, cosine, INHERITED)
                _add(self._like, row, (0, -alike), label)
            elif row not in self._has_category:
                inherits = alike >= self._book.params.min_alike
                (p if inherits else maybe)[row] = alike
                label = Label(newest.name, alike, cosine, INHERITED)
                _add(self._called if inherits else self._like, row, (2, -alike), label)
        waiting = any(self._book.held(one) for one in group)
        given = GivenName(newest.name, newest.told, p, maybe, waiting)
        self._given.setdefault(thing_of(newest.name), []).append(given)

    def names(self) -> Names:
        """Return what was taken in."""
        given = {thing: tuple(names) for thing, names in self._given.items()}
        return Names(given, _in_order(self._called), _in_order(self._like))

    def _rows_of(self, kind: str) -> set[int]:
        rows = (self._at(one)[0] for one in self._book.taught if one.kind == kind)
        return {row for row in rows if row is not None}

    def _at(self, one: Taught) -> tuple[int | None, float]:
        """Return the row of what was taught, and p that it is that."""
        held = self._book.held(one)
        return (self._find(held.instance_id), held.p) if held else (None, 0.0)

    def _taught(self, group: list[Taught]) -> dict[int, float]:
        """Return the rows that were taught, with p."""
        p: dict[int, float] = {}
        for one in group:
            row, again = self._at(one)
            if row is not None:
                p[row] = max(p.get(row, 0.0), self._book.params.certainty * again)
        return p

    def _alike(self, group: list[Taught], taught: set[int]) -> Iterator[tuple[int, float, float]]:
        """Yield the rows that look like what was taught: p and cosine of the closest example."""
        compared = [self._album.cosines(one, self._ids) for one in group]
        cosines = [one for one in compared if one is not None]
        if not cosines or not len(self._ids):
            return
        cosine = np.max(cosines, axis=0)
        p = np.minimum(self._album.judgement.of_category(cosine), self._book.params.certainty)
        heirs = np.flatnonzero((p >= self._book.params.maybe_alike) & self._is_object)
        for row in heirs[np.argsort(-p[heirs], kind="stable")][:MAX_HEIRS].tolist():
            if row not in taught:
                yield row, float(p[row]), float(cosine[row])


_Ranked = dict[int, list[tuple[tuple[int, float], Label]]]
"""Row -> labels with their rank, the lowest first."""


def _add(ranked: _Ranked, row: int, rank: tuple[int, float], label: Label) -> None:
    ranked.setdefault(row, []).append((rank, label))


def _in_order(ranked: _Ranked) -> dict[int, tuple[Label, ...]]:
    return {
        row: tuple(label for _, label in sorted(labels, key=lambda pair: pair[0]))
        for row, labels in ranked.items()
    }


def with_names(snapshot: SceneSnapshot, names: Names) -> SceneSnapshot:
    """Return a snapshot of the encoder's labels as one where things are called as taught."""
    if names is NO_NAMES:
        return snapshot
    instances = list(snapshot.instances)
    for row, labels in names.called.items():
        instances[row] = replace(instances[row], label=labels[0])
    return replace(snapshot, instances=tuple(instances), names=names)
