"""The rectangle on the floor that a thing stands above."""

import math
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64


@dataclass(frozen=True, slots=True)
class Footprint:
    """A rectangle in the world's xy plane, metres.

    Attributes:
        x: centre; ``y``: centre.
        half_width: half its length along its own x axis; ``half_depth``: along its own y axis.
        yaw: radians from the world's x axis to its own.
    """

    x: float
    y: float
    half_width: float
    half_depth: float
    yaw: float = 0.0

    def grown(self, margin_m: float) -> "Footprint":
        """Return it with every side moved outwards."""
        return Footprint(
            self.x,
            self.y,
            self.half_width + margin_m,
            self.half_depth + margin_m,
            self.yaw,
        )

    def corners(self) -> Float64:
        """Return its four corners, (4, 2), counter-clockwise."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        w, d = self.half_width, self.half_depth
        own = np.array([[-w, -d], [w, -d], [w, d], [-w, d]])
        corners: Float64 = own @ np.array([[c, s], [-s, c]]) + (self.x, self.y)
        return corners

    def at(self, ahead_x: float, ahead_y: float) -> tuple[float, float]:
        """Return the world position of a point given in its own axes."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return self.x + c * ahead_x - s * ahead_y, self.y + s * ahead_x + c * ahead_y

    def within(self, width_m: float, depth_m: float) -> bool:
        """Tell whether it lies in the rectangle from the origin to (width, depth)."""
        corners = self.corners()
        tolerance = 1e-6
        return bool(
            (corners >= -tolerance).all()
            and (corners <= (width_m + tolerance, depth_m + tolerance)).all()
        )

    def overlaps(self, other: "Footprint") -> bool:
        """Tell whether the two share more than an edge (separating axes)."""
        reach = math.hypot(self.half_width, self.half_depth) + math.hypot(
            other.half_width, other.half_depth
        )
        if (self.x - other.x) ** 2 + (self.y - other.y) ** 2 > reach * reach:
            return False
        mine, theirs = self.corners(), other.corners()
        return not any(_separated(mine, theirs, yaw) for yaw in (self.yaw, other.yaw))


def _separated(a: Float64, b: Float64, yaw: float) -> bool:
    """Tell whether an edge direction of a rectangle, or the one across it, parts two polygons."""
    c, s = math.cos(yaw), math.sin(yaw)
    axes = np.array([[c, -s], [s, c]])
    on_a, on_b = a @ axes, b @ axes
    touching = 1e-6
    apart = (on_a.max(0) <= on_b.min(0) + touching) | (on_b.max(0) <= on_a.min(0) + touching)
    return bool(apart.any())
