"""A node beside a run that keeps the map as it was at chosen moments."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sceneq_core.arrays import Float32, Int64
from sceneq_core.mapping.replica import MapReplica
from sceneq_nodes._bus import Bus, Context, Received
from sceneq_nodes._convert import map_delta_from_message
from sceneq_schemas.topics import MAP_DELTA
from sceneq_tools.evaluation.predictions import REACH_M, nearest_ids


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """The map at one moment: float32 (M, 3) metres and the instance int64 (M,), 0 = none."""

    points_world: Float32
    instance_id: Int64

    def at(self, points_world: Float32) -> Int64:
        """Return the instance at every point, 0 = none in reach."""
        return nearest_ids(self.points_world, self.instance_id, points_world, REACH_M)


class MapWatcher:
    """A node that keeps the map as it was before each of ``cuts`` and as it is now."""

    Params: ClassVar[type] = object
    idle_s: ClassVar[float] = 1.0

    def __init__(self, cuts: Sequence[int], context: Context) -> None:
        self._scene = context.scene
        self._cuts = list(cuts)
        self._replica = MapReplica()
        self.seen: list[Seen] = []

    def open(self, bus: Bus) -> None:
        """Listen to the map."""
        bus.subscribe(MAP_DELTA, depth=1, scene=self._scene)

    def step(self, received: Received | None) -> None:
        """Look at the map before the first keyframe behind a cut changes it."""
        if received is None:
            return
        delta = map_delta_from_message(received.message)
        while self._cuts and delta.frame_seq >= self._cuts[0]:
            self._cuts.pop(0)
            self.look()
        self._replica.apply(delta)

    def look(self) -> None:
        """Keep the map as it is now."""
        points_world, _, instance_id = self._replica.cloud()
        self.seen.append(Seen(points_world, instance_id.astype(np.int64)))

    def close(self) -> None:
        """Nothing to release."""
