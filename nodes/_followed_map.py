"""A copy of the scene's map that stays up to date, for nodes that show it."""

import logging
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext

from sceneq_core.mapping.replica import MapReplica
from sceneq_nodes._bus import Bus
from sceneq_nodes._convert import map_delta_from_message
from sceneq_nodes._follow import Follower
from sceneq_schemas.map import MapDelta
from sceneq_schemas.topics import MAP_DELTA, MAP_JOURNAL, MAP_SNAPSHOT

log = logging.getLogger(__name__)


class FollowedMap:
    """Calls ``told`` with every change that the copy has taken over.

    A delta that contradicts the map is left out, logged and counted as ``map_delta_bad``. ``lock``
    is held while the copy changes, where other threads read it.

    Attributes:
        replica: the copy.
    """

    def __init__(
        self,
        bus: Bus,
        scene: str,
        told: Callable[[MapDelta], None],
        lock: AbstractContextManager[object] | None = None,
    ) -> None:
        self.replica = MapReplica()
        self._bus = bus
        self._told = told
        self._lock = lock or nullcontext()
        self._follower = Follower(
            *(bus, MAP_DELTA, MAP_SNAPSHOT, self._take), journal_topic=MAP_JOURNAL, scene=scene
        )

    def open(self) -> None:
        """Subscribe, and ask for what there is."""
        self._follower.open()

    def offer(self, delta: MapDelta) -> None:
        """Take in a delta as it comes."""
        self._follower.offer(delta)

    def tick(self) -> None:
        """Heal what is missing, when nothing comes."""
        self._follower.tick()

    def _take(self, delta: MapDelta) -> None:
        try:
            with self._lock:
                self.replica.apply(map_delta_from_message(delta))
        except ValueError as error:
            self._bus.count("map_delta_bad")
            log.warning("map %d:%d: %s", delta.epoch, delta.seq, error)
            return
        self._told(delta)
