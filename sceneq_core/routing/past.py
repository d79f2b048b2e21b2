"""What is gone from the map, as it was when it was last there."""

from collections import OrderedDict
from dataclasses import dataclass, replace
from typing import Any

from sceneq_core.mapping.delta import REMOVED, Instance
from sceneq_core.routing.described import Described

CAPACITY = 500
"""So many are remembered, the last ones to go: a robot's day of things carried away."""


@dataclass(frozen=True, slots=True, eq=False)
class Gone:
    """An instance that was answered with and is not in the map any more; ``views`` as they were."""

    geometry: Instance
    views: tuple[Any, ...]
    described: Described


class Past:
    """Remembers what is gone from one map, the latest last."""

    def __init__(self, capacity: int = CAPACITY) -> None:
        self._capacity = capacity
        self._gone: OrderedDict[int, Gone] = OrderedDict()

    def keep(self, gone: Gone, stamp_ns: int) -> None:
        """Remember something that went at ``stamp_ns``; the oldest beyond the capacity is lost."""
        geometry = replace(gone.geometry, state=REMOVED, state_since_ns=stamp_ns)
        self._gone[geometry.instance_id] = replace(gone, geometry=geometry)
        self._gone.move_to_end(geometry.instance_id)
        while len(self._gone) > self._capacity:
            self._gone.popitem(last=False)

    def forget(self, instance_id: int) -> None:
        """It is back."""
        self._gone.pop(instance_id, None)

    def clear(self) -> None:
        """Another map: its ids mean other things."""
        self._gone.clear()

    def all(self) -> tuple[Gone, ...]:
        """Return what is gone, by id."""
        return tuple(self._gone[key] for key in sorted(self._gone))
