"""Keeps on disk what views has seen: keyframes with their pictures, and what was chosen of them."""

import logging
import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import zstandard

from sceneq_core.arrays import Int32
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.state import StateError, build, take_apart
from sceneq_core.views.keyframe import Keyframe
from sceneq_core.views.selector import ViewSelector
from sceneq_core.views.view import View, ViewSet
from sceneq_nodes._convert import map_delta_from_message
from sceneq_nodes._item_store import Change, Item, ItemStore
from sceneq_nodes._seen_frames import SeenFrames
from sceneq_nodes._set_aside import DamageError, StoreError
from sceneq_nodes._state_bytes import packed, unpacked
from sceneq_schemas.codec import decode, encode
from sceneq_schemas.map import MapDelta

log = logging.getLogger(__name__)

FILE = "views.sqlite"
KEYFRAME, VIEWS, PLACES = "keyframe", "views", "places"
MAP, DELTA, SEEN, REST = "map", "delta", "seen", "rest"
FORM = 1
"""To be raised with every change of what the items hold."""
DELTAS = 32
"""So many changes of the map are kept before it is written whole again."""
MAX_DELTA_BYTES = 1 << 28
_ZIP, _UNZIP = zstandard.ZstdCompressor(1), zstandard.ZstdDecompressor()
_STAMP = struct.Struct("<q")
READING = (
    *(DamageError, StateError, KeyError, TypeError, ValueError),
    *(zstandard.ZstdError, struct.error),
)
"""How reading fails what is damaged or another version's."""


@dataclass(frozen=True, slots=True)
class Kept:
    """What the last run left: keyframes by seq, the places' coordinates, and the rest."""

    keyframes: Mapping[int, Keyframe]
    place_coords: Int32
    replica: MapReplica
    view_sets: Sequence[ViewSet]
    selector: Mapping[str, Any]
    seen: Sequence[tuple[int, int]]
    beside: dict[str, Any] = field(default_factory=dict)


class ViewStore:
    """The durable side of one ``ViewSelector``, and of what was ``seen``.

    Raises:
        StoreError: the file cannot be used; nothing has been changed.
    """

    def __init__(
        self,
        scene_folder: Path,
        selector: ViewSelector,
        seen: SeenFrames,
        beside: Callable[[], dict[str, Any]],
        count: Callable[[str], None],
    ) -> None:
        self._selector = selector
        self._seen = seen
        self._beside = beside
        self._stored: dict[int, Keyframe] = {}
        self._views: dict[int, tuple[View, ...]] = {}
        self._places = self._deltas = 0
        self._new_deltas: list[Item] = []
        self._needs_map = False
        self._items = ItemStore(scene_folder / FILE, self._everything, count, FORM)

    @property
    def is_behind(self) -> bool:
        """Whether the disk failed, and what is on it is old."""
        return self._items.is_behind

    def resume(self) -> dict[str, Any]:
        """Bring the selector to where the last run ended; return what lay beside, {} if nothing."""
        try:
            kept = self._read()
        except READING as error:
            self._items.start_anew(_reason(error))
            return {}
        if kept is None:
            return {}
        self._selector.resume(
            kept.keyframes, kept.place_coords, kept.replica, kept.view_sets, kept.selector
        )
        self._stored = {k.seq: k for k in self._selector.archive}
        self._views = {one.instance_id: one.views for one in self._selector.view_sets()}
        self._places = len(kept.place_coords)
        self._seen.resume(kept.seen)
        return kept.beside

    def follow(self, delta: MapDelta) -> None:
        """Note a change of the map that the selector has taken over."""
        self._deltas += 1
        self._new_deltas.append(Item(DELTA, self._deltas, _ZIP.compress(encode(delta))))
        self._needs_map |= delta.full or self._deltas >= DELTAS

    def keep(self) -> None:
        """Commit what has changed since the last call, before anybody is told."""
        archive = self._selector.archive
        new = [k for k in archive if self._stored.get(k.seq) is not k]
        gone = tuple((KEYFRAME, seq) for seq in self._stored if seq not in archive)
        old_deltas = range(1, self._deltas + 1) if self._needs_map else ()
        gone += tuple((DELTA, number) for number in old_deltas)
        views = {one.instance_id: one.views for one in self._selector.view_sets()}
        gone += tuple((VIEWS, number) for number in self._views.keys() - views.keys())
        gone += tuple((SEEN, seq) for seq in self._seen.removed)
        chosen = [n for n in views if not _are_same(views[n], self._views.get(n, ()))]
        put = (
            *map(_keyframe_item, new),
            *(_views_item(number, views[number]) for number in chosen),
            *map(_seen_item, self._seen.added.items()),
            *self._new_places(),
            *self._new_map(),
            self._rest(),
        )
        self._items.commit(Change(put, gone))
        self._views = views
        self._stored = {keyframe.seq: keyframe for keyframe in archive}
        self._seen.settle()

    def close(self) -> None:
        """Let go of the file."""
        self._items.close()

    def _everything(self) -> Iterator[Item]:
        yield from map(_keyframe_item, self._selector.archive)
        for view_set in self._selector.view_sets():
            yield _views_item(view_set.instance_id, view_set.views)
        yield from map(_seen_item, self._seen.items())
        yield Item(PLACES, 0, _array_bytes(self._selector.places.coords(0)))
        yield self._map_item()
        yield self._rest()

    def _new_places(self) -> Iterator[Item]:
        first, self._places = self._places, len(self._selector.places)
        if self._places > first:
            coords = self._selector.places.coords(first)
            yield Item(PLACES, first, _array_bytes(coords))

    def _new_map(self) -> list[Item]:
        """Return what tells the map as of now: the changes since it was written whole, or that."""
        items, self._new_deltas = self._new_deltas, []
        if self._needs_map:
            self._needs_map, self._deltas = False, 0
            items = [self._map_item()]
        return items

    def _map_item(self) -> Item:
        return Item(MAP, 0, packed(take_apart(self._selector.replica)))

    def _rest(self) -> Item:
        state = take_apart({"selector": self._selector.parts(), "beside": self._beside()})
        return Item(REST, 0, packed(state))

    def _read(self) -> Kept | None:
        items = {(item.kind, item.number): item.data for item in self._items.items()}
        if not items:
            return None
        rest = build(unpacked(items[REST, 0]))
        coords = [np.zeros((0, 3), np.int32)]
        for _, first in sorted(key for key in items if key[0] == PLACES):
            if first != sum(map(len, coords)):
                raise DamageError(f"places from {sum(map(len, coords))} are missing")
            coords.append(build(unpacked(items[PLACES, first])))
        replica = build(unpacked(items[MAP, 0])) if (MAP, 0) in items else MapReplica()
        for _, number in sorted(key for key in items if key[0] == DELTA):
            message = decode(MapDelta, _UNZIP.decompress(items[DELTA, number], MAX_DELTA_BYTES))
            replica.apply(map_delta_from_message(message))
            self._deltas = number
        keyframes = {n: build(unpacked(d)) for (kind, n), d in items.items() if kind == KEYFRAME}
        places = np.concatenate(coords)
        sets = [ViewSet(n, build(unpacked(d))) for (kind, n), d in items.items() if kind == VIEWS]
        self._check_known(rest["selector"], replica)
        seen = [(n, _STAMP.unpack(d)[0]) for (kind, n), d in items.items() if kind == SEEN]
        return Kept(keyframes, places, replica, sets, rest["selector"], seen, rest["beside"])

    def _check_known(self, selector: Mapping[str, Any], replica: MapReplica) -> None:
        """Refuse what another version kept: the selector would fail with it half-way."""
        for name, kept, now in (
            ("selector", selector, self._selector.parts()),
            ("archive", selector.get("archive", {}), self._selector.archive.parts()),
            ("map", vars(replica), vars(MapReplica())),
        ):
            if differing := kept.keys() ^ now.keys():
                told = ", ".join(sorted(map(str, differing)))
                raise DamageError(f"kept by another version: its {name} differs in {told}")


def open_view_store(
    scene_folder: Path | None,
    selector: ViewSelector,
    seen: SeenFrames,
    beside: Callable[[], dict[str, Any]],
    count: Callable[[str], None],
) -> ViewStore | None:
    """Return the store of ``scene_folder``, ``None`` without one or where it cannot be used.

    ``beside`` returns what else is to come back, plain values and arrays. A store that cannot be
    used is counted (``store_failed``), told, and left alone.
    """
    if scene_folder is None:
        return None
    try:
        return ViewStore(scene_folder, selector, seen, beside, count)
    except StoreError as error:
        count("store_failed")
        log.error("%s; views are kept in memory only", error)
        return None


def _reason(error: Exception) -> str:
    return f"{error} is missing" if isinstance(error, KeyError) else str(error)


def _keyframe_item(keyframe: Keyframe) -> Item:
    return Item(KEYFRAME, keyframe.seq, packed(take_apart(keyframe)))


def _seen_item(frame: tuple[int, int]) -> Item:
    seq, stamp_ns = frame
    return Item(SEEN, seq, _STAMP.pack(stamp_ns))


def _views_item(instance_id: int, views: tuple[View, ...]) -> Item:
    return Item(VIEWS, instance_id, packed(take_apart(views)))


def _are_same(one: tuple[View, ...], other: tuple[View, ...]) -> bool:
    return len(one) == len(other) and all(a is b for a, b in zip(one, other, strict=True))


def _array_bytes(array: Int32) -> bytes:
    return packed(take_apart(array))
