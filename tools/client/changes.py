"""What happens in the map: things appear, move, are not found again, vanish."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from sceneq_nodes._wire import from_bytes
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.map import MapDelta
from sceneq_schemas.topics import MAP_DELTA

GAP = "gap"
"""Messages of the map were lost on the way: ask, if you need to know what happened meanwhile."""


@dataclass(frozen=True, slots=True)
class Change:
    """A transition of ``instance_id`` at capture time ``stamp_ns``.

    ``kind`` is appeared, confirmed, moved, stale, seen_again, split, merged or removed, with
    ``other_id`` what it was split from or merged into, else 0; or ``gap``, of no instance.
    """

    kind: str
    instance_id: int
    other_id: int
    stamp_ns: int


class MapEvents:
    """Turns messages of the map into changes, and notices what is missing between them."""

    def __init__(self, tell: Callable[[Change], None]) -> None:
        self._tell = tell
        self._epoch, self._seq = 0, 0
        self.undecodable = 0

    def hear(self, _key: str, _encoding: str, payload: bytes) -> None:
        """Take one message; what is not one of the map is counted."""
        try:
            delta = from_bytes(MAP_DELTA, payload)
        except DecodeError:
            self.undecodable += 1
            return
        for change in self._changes(delta):
            self._tell(change)

    def _changes(self, delta: MapDelta) -> Iterator[Change]:
        follows = (delta.epoch, delta.seq) == (self._epoch, self._seq + 1)
        if self._epoch and not follows:
            yield Change(GAP, 0, 0, delta.stamp_ns)
        self._epoch, self._seq = delta.epoch, delta.seq
        for event in delta.events:
            yield Change(event.kind, event.instance_id, event.other_id, event.stamp_ns)
