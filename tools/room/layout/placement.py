"""Poses of things, and whether two of them are in each other's way."""

import math

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_tools.room.layout.columns import solid_points, taken
from sceneq_tools.room.layout.footprint import Footprint
from sceneq_tools.room.layout.probe import bounds
from sceneq_tools.room.mesh import Mesh
from sceneq_tools.room.room import Thing

TOUCH_M = 0.002
"""Columns that share less than this only touch."""


def pose(x: float, y: float, z: float = 0.0, yaw: float = 0.0) -> Float64:
    """Return the (4, 4) pose of something upright, turned by ``yaw`` radians about z."""
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, z], [0, 0, 0, 1]], np.float64)


def yaw_of(T_world: Float64) -> float:
    """Return how far an upright pose is turned about z, radians."""
    return math.atan2(T_world[1, 0], T_world[0, 0])


def footprint(mesh: Mesh, T_world: Float64) -> Footprint:
    """Return the rectangle on the floor below a mesh in a pose."""
    low, high = bounds(mesh)
    x, y, _ = T_world[:3, :3] @ ((low + high) / 2) + T_world[:3, 3]
    half = (high - low) / 2
    return Footprint(float(x), float(y), float(half[0]), float(half[1]), yaw_of(T_world))


def front_area(mesh: Mesh, T_world: Float64, front_m: float) -> Footprint:
    """Return the floor in front of a mesh, as wide as it is."""
    own = footprint(mesh, T_world)
    x, y = own.at(0.0, -own.half_depth - front_m / 2)
    return Footprint(x, y, own.half_width, max(front_m / 2 - 0.005, 0.001), own.yaw)


def heights(mesh: Mesh, T_world: Float64) -> tuple[float, float]:
    """Return the lowest and the highest z of a mesh in a pose, metres."""
    low, high = bounds(mesh)
    return float(T_world[2, 3] + low[2]), float(T_world[2, 3] + high[2])


def share_height(mesh: Mesh, T_world: Float64, other: Mesh, T_other: Float64) -> bool:
    """Tell whether some height belongs to both."""
    low, high = heights(mesh, T_world)
    other_low, other_high = heights(other, T_other)
    return low < other_high - TOUCH_M and other_low < high - TOUCH_M


def collide(mesh: Mesh, T_world: Float64, other: Mesh, T_other: Float64) -> bool:
    """Tell whether two meshes would be in the same place, taken as solid columns.

    A chair may stand under a table top, and a lamp's arm reach over a sofa; nothing may stand
    inside something else, not even in its hollow (that is what supports are for).
    """
    if not share_height(mesh, T_world, other, T_other):
        return False
    if not footprint(mesh, T_world).overlaps(footprint(other, T_other)):
        return False
    if len(solid_points(mesh)) > len(solid_points(other)):
        mesh, T_world, other, T_other = other, T_other, mesh, T_world
    points = solid_points(mesh)
    T_other_mesh = np.linalg.inv(T_other) @ T_world
    xy = points[:, :2] @ T_other_mesh[:2, :2].T + T_other_mesh[:2, 3]
    lift = T_other_mesh[2, 3]
    return bool(
        taken(other, xy, points[:, 2] + lift + TOUCH_M, points[:, 3] + lift - TOUCH_M).any()
    )


def in_the_way(mesh: Mesh, T_world: Float64, things: list[Thing]) -> Thing | None:
    """Return the first thing that is where the mesh would be, or ``None``."""
    for thing in things:
        if collide(mesh, T_world, thing.mesh, thing.T_world_thing):
            return thing
    return None
