"""From where a map is looked at."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.mapping.replica import MapReplica

ELEVATION_DEG = 42.0
DISTANCE = 2.2
"""In radii of the map; Rerun's field of view shows all of it from there."""
SAMPLED = 20_000
GROWN = 1.3
MIN_RADIUS_M = 0.1
HIGH_PERCENT = 60


@dataclass(frozen=True, slots=True)
class Eye:
    """A viewpoint: ``position`` and ``target`` (3,) metres in the world frame, ``up`` (3,)."""

    position: Float64
    target: Float64
    up: Float64


class Eyes:
    """Finds a new viewpoint when the map has outgrown the last one."""

    def __init__(self) -> None:
        self._radius_m = MIN_RADIUS_M

    def look(self, replica: MapReplica) -> Eye | None:
        """Return the viewpoint to take, ``None`` as long as the last one will do."""
        points_world = replica.points_world[replica.alive]
        points_world = points_world[:: 1 + len(points_world) // SAMPLED].astype(np.float64)
        if not len(points_world) or not replica.up_world.any():
            return None
        low, high = np.percentile(points_world, [1, 99], axis=0)
        radius_m = float(np.linalg.norm(high - low)) / 2
        if radius_m < GROWN * self._radius_m:
            return None
        self._radius_m = radius_m
        target, up = (low + high) / 2, replica.up_world
        elevation = np.radians(ELEVATION_DEG)
        away = np.cos(elevation) * open_side(points_world - target, up) + np.sin(elevation) * up
        return Eye(target + DISTANCE * radius_m * away, target, up)


def open_side(offsets: Float64, up_world: Float64) -> Float64:
    """Return the level direction (3,) with the fewest high points: no wall hides the room.

    ``offsets`` are the points (N, 3) seen from the middle of the map, metres.
    """
    axes = np.linalg.svd(up_world[None])[2][1:]
    angles = np.radians(np.arange(0, 360, 15))
    directions = np.cos(angles)[:, None] * axes[0] + np.sin(angles)[:, None] * axes[1]
    height = offsets @ up_world
    high = offsets[height > np.percentile(height, HIGH_PERCENT)]
    in_the_way = np.maximum(high @ directions.T, 0).sum(axis=0)
    side: Float64 = directions[int(np.argmin(in_the_way))]
    return side
