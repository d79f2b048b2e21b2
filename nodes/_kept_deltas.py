"""The last deltas of the map on disk: readers go on from them after any end of mapping.

A delta is committed before it is told. What a reader missed when everything ended at once lies
partly before the newest checkpoint, and no entry of the journal is done again for that.
"""

import logging
import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from heapq import merge
from operator import attrgetter
from pathlib import Path

import zstandard

from sceneq_nodes._convert import map_delta_message
from sceneq_nodes._item_store import Change, Item, ItemStore
from sceneq_nodes._map_store import MapStore, NoStore
from sceneq_nodes._order import says_nothing
from sceneq_nodes._recent_deltas import RecentDeltas
from sceneq_nodes._set_aside import DamageError, StoreError
from sceneq_schemas.codec import decode, encode
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.map import MapDelta

log = logging.getLogger(__name__)

FILE = "told.sqlite"
DELTA, QUIET = "delta", "quiet"
FORM = 1
"""To be raised with every change of what the items hold."""
KEPT = 64
"""So many changes are on disk: more than a reader that loses nothing can be behind."""
MAX_BYTES = 1 << 28
_BEFORE = struct.Struct("<q")
_ZIP, _UNZIP = zstandard.ZstdCompressor(1), zstandard.ZstdDecompressor()


@dataclass(frozen=True, slots=True)
class LastRun:
    """What the map was brought back from.

    ``told_after`` is the number of the last delta before those ``again``, which were made anew;
    ``first_seq`` that before the first of this run.
    """

    epoch: int
    told_after: int
    first_seq: int
    again: Sequence[MapDelta]


@dataclass(frozen=True, slots=True)
class _Told:
    """A delta and the number of the one before it that changed something."""

    before: int
    delta: MapDelta


class KeptDeltas(RecentDeltas):
    """The recent deltas of a map that is kept in ``folder``.

    Raises:
        StoreError: the file cannot be used; nothing has been changed.
    """

    def __init__(self, folder: Path, last: LastRun, count: Callable[[str], None]) -> None:
        self._items = ItemStore(folder / FILE, self._everything, count, FORM)
        told = self._told()
        complete_after, before = _continued(told, last)
        super().__init__(complete_after, last.first_seq, before)
        kept = {_key(delta): (delta, before) for delta, before in self._kept()}
        put = tuple(_item(*kept[key]) for key in kept.keys() - told.keys())
        self._items.commit(Change(put, tuple(told.keys() - kept.keys())))

    def add(self, delta: MapDelta) -> None:
        """Commit the newest, and let go of the oldest when there are too many."""
        item = _item(delta, self._newest())
        gone = [*map(_key, self._remember(delta))]
        if len(self._deltas) > KEPT:
            gone.append(_key(self._deltas[-KEPT - 1]))
        self._items.commit(Change((item,), tuple(gone)))

    def close(self) -> None:
        """Let go of the file."""
        self._items.close()

    def _newest(self) -> int:
        return self._deltas[-1].seq if self._deltas else self._complete_after

    def _everything(self) -> Iterator[Item]:
        return (_item(delta, before) for delta, before in self._kept())

    def _kept(self) -> Iterator[tuple[MapDelta, int]]:
        """Yield what is to be on disk, each with the number of the change before it."""
        is_more = len(self._deltas) > KEPT
        before = self._deltas[-KEPT - 1].seq if is_more else self._complete_after
        for delta in merge(list(self._deltas)[-KEPT:], self._quiet, key=attrgetter("seq")):
            yield delta, before
            before = before if says_nothing(delta) else delta.seq

    def _told(self) -> dict[tuple[str, int], _Told]:
        """Return what the last runs told by kind and number; nothing when the file is damaged."""
        try:
            return {(item.kind, item.number): _read(item) for item in self._items.items()}
        except (DamageError, DecodeError, struct.error, zstandard.ZstdError) as error:
            self._items.start_anew(str(error))
            return {}


def open_deltas(store: MapStore | NoStore, count: Callable[[str], None]) -> RecentDeltas:
    """Return what was told of the map that ``store`` brought back, to be gone on with.

    A file that cannot be used is counted (``store_failed``), told, and left alone; then what is
    told is kept in memory only, as it is where the map is.
    """
    epoch = store.epoch
    again = [map_delta_message(delta, epoch, seq) for seq, delta in store.repeated]
    last = LastRun(epoch, store.told_after, store.first_seq, again)
    if store.told_folder is not None:
        try:
            return KeptDeltas(store.told_folder, last, count)
        except StoreError as error:
            count("store_failed")
            log.error("%s; what was told is kept in memory only", error)
    return RecentDeltas(last.told_after, last.first_seq, again)


def _continued(told: dict[tuple[str, int], _Told], last: LastRun) -> tuple[int, list[MapDelta]]:
    """Return the number beyond which nothing is missing, and the deltas beyond it.

    Those up to the checkpoint are as they were told, as far back as none is missing; those after
    it as they were made anew. One that was told and not made anew had lost what it tells of.
    """
    of_map = [one for one in told.values() if one.delta.epoch == last.epoch]
    changes = {one.delta.seq: one for one in of_map if not says_nothing(one.delta)}
    seq, kept = _last_change(of_map, last.told_after), list(last.again)
    while (one := changes.get(seq)) is not None:
        kept.append(one.delta)
        seq = one.before
    lost = changes.keys() - {delta.seq for delta in kept}
    end = min((number for number in lost if number > last.told_after), default=last.first_seq)
    quiet = (one.delta for one in of_map if says_nothing(one.delta))
    kept += (delta for delta in quiet if seq < delta.seq < end)
    return seq, sorted(kept, key=lambda delta: delta.seq)


def _last_change(told: list[_Told], told_after: int) -> int:
    """Return the number of the last delta up to ``told_after`` that changed something.

    The one told next names it; when that is not known, ``told_after`` itself.
    """
    later = (one for one in told if one.delta.seq >= told_after)
    one = min(later, key=lambda one: one.delta.seq, default=None)
    if one is None or (one.delta.seq == told_after and not says_nothing(one.delta)):
        return told_after
    return one.before if one.before <= told_after else told_after


def _key(delta: MapDelta) -> tuple[str, int]:
    return (QUIET if says_nothing(delta) else DELTA), delta.seq


def _item(delta: MapDelta, before: int) -> Item:
    kind, number = _key(delta)
    return Item(kind, number, _BEFORE.pack(before) + _ZIP.compress(encode(delta)))


def _read(item: Item) -> _Told:
    (before,) = _BEFORE.unpack_from(item.data)
    return _Told(before, decode(MapDelta, _UNZIP.decompress(item.data[_BEFORE.size :], MAX_BYTES)))
