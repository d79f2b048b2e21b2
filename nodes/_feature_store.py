"""Keeps descriptors on disk, each with a digest of the views it was made of."""

import hashlib
import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sceneq_core.state import StateError, build, take_apart
from sceneq_nodes._item_store import Change, Item, ItemStore
from sceneq_nodes._set_aside import DamageError, StoreError
from sceneq_nodes._state_bytes import packed, unpacked
from sceneq_schemas.codec import decode, encode
from sceneq_schemas.feature import Descriptor, FeatureDelta
from sceneq_schemas.view import ViewSet

log = logging.getLogger(__name__)

INSTANCE, REST = "instance", "rest"
BESIDE = frozenset({"epoch", "run", "map_epoch", "latest", "view_epoch"})
"""What the node that keeps them finds beside them when it comes back."""
FORM = 1
"""To be raised with every change of what the items hold."""


@dataclass(slots=True)
class Features:
    """The descriptors of a scene by instance, and what each was ``made_of``."""

    descriptors: dict[int, Descriptor] = field(default_factory=dict)
    made_of: dict[int, bytes] = field(default_factory=dict)


class FeatureStore:
    """The durable descriptors of one model.

    Raises:
        StoreError: the file cannot be used; nothing has been changed.
    """

    def __init__(self, scene_folder: Path, model: str, count: Callable[[str], None]) -> None:
        self.kept = Features()
        self._beside: dict[str, Any] = {}
        path = scene_folder / f"features-{model}.sqlite"
        self._items = ItemStore(path, self._everything, count, FORM)

    @property
    def is_behind(self) -> bool:
        """Whether the disk failed, and what is on it is old."""
        return self._items.is_behind

    def resume(self) -> dict[str, Any]:
        """Read what the last run left to ``kept``; return what lay beside, {} if nothing did."""
        try:
            return self._read()
        except (DamageError, StateError, KeyError, TypeError, ValueError) as error:
            self.kept, self._beside = Features(), {}
            is_key = isinstance(error, KeyError)
            self._items.start_anew(f"{error} is missing" if is_key else str(error))
            return {}

    def keep(self, delta: FeatureDelta, made_of: dict[int, bytes], beside: dict[str, Any]) -> None:
        """Commit a change before anybody is told; ``made_of`` tells it of the changed ones."""
        kept, self._beside = self.kept, beside
        before = list(kept.descriptors) if delta.full else delta.removed.tolist()
        for number in before:
            kept.descriptors.pop(number, None)
            kept.made_of.pop(number, None)
        kept.descriptors |= {one.instance_id: one for one in delta.descriptors}
        kept.made_of |= made_of
        put = (*(self._item(one.instance_id) for one in delta.descriptors), self._rest())
        self._items.commit(Change(put, tuple((INSTANCE, number) for number in before)))

    def note(self, beside: dict[str, Any]) -> None:
        """Commit what lies beside the descriptors."""
        self._beside = beside
        self._items.commit(Change((self._rest(),)))

    def close(self) -> None:
        """Let go of the file."""
        self._items.close()

    def _everything(self) -> Iterator[Item]:
        yield from map(self._item, self.kept.descriptors)
        yield self._rest()

    def _item(self, number: int) -> Item:
        message = encode(self.kept.descriptors[number])
        parts = {"message": message, "made_of": self.kept.made_of.get(number, b"")}
        return Item(INSTANCE, number, packed(take_apart(parts)))

    def _rest(self) -> Item:
        return Item(REST, 0, packed(take_apart(self._beside)))

    def _read(self) -> dict[str, Any]:
        beside: dict[str, Any] = {}
        for item in self._items.items():
            parts = build(unpacked(item.data))
            if item.kind == REST:
                beside = parts
            else:
                self.kept.descriptors[item.number] = decode(Descriptor, parts["message"])
                self.kept.made_of[item.number] = parts["made_of"]
        if self.kept.descriptors and not beside:
            raise DamageError("the rest is missing")
        if beside and (missing := BESIDE - beside.keys()):
            raise DamageError(f"kept by another version: without {', '.join(sorted(missing))}")
        self._beside = beside
        return beside


def open_feature_store(
    scene_folder: Path | None, model: str, count: Callable[[str], None]
) -> FeatureStore | None:
    """Return the store of ``scene_folder``, ``None`` without one or where it cannot be used.

    A store that cannot be used is counted (``store_failed``), told, and left alone.
    """
    if scene_folder is None:
        return None
    try:
        return FeatureStore(scene_folder, model, count)
    except StoreError as error:
        count("store_failed")
        log.error("%s; descriptors are kept in memory only", error)
        return None


def digest_of(view_set: ViewSet) -> bytes:
    """Return what tells a view set from every other."""
    return hashlib.sha256(encode(view_set)).digest()
