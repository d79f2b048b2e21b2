"""The four walls and where things stand along them."""

import math
from dataclasses import dataclass

from sceneq_core.arrays import Float64
from sceneq_tools.room.layout.placement import pose
from sceneq_tools.room.room import FLOOR_ID


@dataclass(frozen=True, slots=True)
class Wall:
    """One wall seen from the room: x runs along it to the right, +y into it, z up.

    Something with its back to the wall has the wall's own orientation.

    Attributes:
        side: 0 south (y = 0), 1 east, 2 north, 3 west.
        x: world position of the wall's left end, ``y`` too.
        yaw: radians from the world's x axis to the wall's.
        length_m: from corner to corner.
    """

    side: int
    x: float
    y: float
    yaw: float
    length_m: float

    @property
    def id(self) -> int:
        """Instance id of the wall: floor and ceiling come first."""
        return FLOOR_ID + 2 + self.side

    def pose(
        self, along_m: float, off_m: float = 0.0, z: float = 0.0, turn: float = 0.0
    ) -> Float64:
        """Return a pose at ``along_m`` from the left end and ``off_m`` away from the wall."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        x = self.x + c * along_m + s * off_m
        y = self.y + s * along_m - c * off_m
        return pose(x, y, z, self.yaw + turn)

    def along(self, x: float, y: float) -> float:
        """Return how far along the wall a world position is."""
        return (x - self.x) * math.cos(self.yaw) + (y - self.y) * math.sin(self.yaw)


def walls_of(width_m: float, depth_m: float) -> tuple[Wall, Wall, Wall, Wall]:
    """Return the south, east, north and west wall of a room."""
    return (
        Wall(0, width_m, 0.0, math.pi, width_m),
        Wall(1, width_m, depth_m, -math.pi / 2, depth_m),
        Wall(2, 0.0, depth_m, 0.0, width_m),
        Wall(3, 0.0, 0.0, math.pi / 2, depth_m),
    )
