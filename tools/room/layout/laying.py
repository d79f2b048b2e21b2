"""Finding a free spot for a thing on another."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float64, UInt8
from sceneq_tools.room.layout.columns import solid_points
from sceneq_tools.room.layout.placement import footprint, heights, pose, yaw_of
from sceneq_tools.room.layout.probe import bounds
from sceneq_tools.room.layout.supports import Support, carries
from sceneq_tools.room.mesh import Mesh
from sceneq_tools.room.room import Thing

HEADROOM_M = 0.01
"""Kept free above a thing on a shelf."""

ELBOW_M = 0.012
"""Kept free between things that stand side by side."""

Preference = Callable[[Float64], Float64]
"""Cost of positions (N, 2) in the host's own frame; the cheapest free one is taken."""


@dataclass(frozen=True, slots=True, eq=False)
class Spot:
    """Where a thing may stand: on which level, and its pose in the world."""

    support: Support
    T_world_thing: Float64


def find_spot(
    mesh: Mesh,
    yaw: float,
    host: Thing,
    level: Support,
    others: Sequence[Thing],
    preference: Preference,
) -> Spot | None:
    """Return the best free spot for a mesh on one level of a host, or ``None``.

    Args:
        mesh: what is to be placed.
        yaw: its turn against the host, radians.
        host: what carries it.
        level: one of the host's supports, or the floor underneath it.
        others: what must not be touched; the host itself may be among them.
        preference: which of the free spots is best.
    """
    low, high = bounds(mesh)
    size = high - low
    roomy = carries(level) & (level.clearance > size[2] + HEADROOM_M)
    if not roomy.any():
        return None
    free = roomy & ~_occupied(level, host, others, float(size[2]))
    kernel = _stamp(size[0] / 2, size[1] / 2, yaw, level.grid.cell_m)
    fits = _eroded(free, kernel)
    rows, columns = np.nonzero(fits)
    if not len(rows):
        return None
    step = level.grid.cell_m
    corner = np.array([level.grid.x, level.grid.y])
    centres: Float64 = (np.stack([columns, rows], axis=1) + 0.5) * step + corner
    best = int(np.argmin(preference(centres)))
    z = _height_below(level, kernel, int(rows[best]), int(columns[best]))
    return Spot(level, _world_pose(host, mesh, centres[best], z, yaw))


def _occupied(level: Support, host: Thing, others: Sequence[Thing], height_m: float) -> Bool:
    """Mark the cells of a level above which something else already is."""
    grid = level.grid
    marks: UInt8 = np.zeros((grid.rows, grid.columns), np.uint8)
    T_host_world = np.linalg.inv(host.T_world_thing)
    near = footprint(host.mesh, host.T_world_thing).grown(ELBOW_M)
    bottom = level.z + host.T_world_thing[2, 3]
    for other in others:
        if other.id == host.id or not _between(other, bottom, bottom + height_m + HEADROOM_M):
            continue
        if not near.overlaps(footprint(other.mesh, other.T_world_thing)):
            continue
        T_host_other = T_host_world @ other.T_world_thing
        points = solid_points(other.mesh)
        low, high = points[:, 2] + T_host_other[2, 3], points[:, 3] + T_host_other[2, 3]
        meets = (low < level.z + height_m + HEADROOM_M) & (high > level.z + 0.003)
        xy = points[meets, :2] @ T_host_other[:2, :2].T + T_host_other[:2, 3]
        cell = np.floor((xy - (grid.x, grid.y)) / grid.cell_m).astype(np.int64)
        cell = cell[((cell >= 0) & (cell < (grid.columns, grid.rows))).all(axis=1)]
        marks[cell[:, 1], cell[:, 0]] = 1
    reach = math.ceil(ELBOW_M / grid.cell_m) * 2 + 1
    grown: Bool = cv2.dilate(marks, np.ones((reach, reach), np.uint8)) > 0
    return grown


def _between(thing: Thing, low: float, high: float) -> bool:
    """Tell whether a thing takes some of the air between two heights."""
    its_low, its_high = heights(thing.mesh, thing.T_world_thing)
    return its_low < high and its_high > low + 0.003


def _stamp(half_width: float, half_depth: float, yaw: float, cell_m: float) -> UInt8:
    """Return the cells a turned rectangle covers when its centre is in the middle cell."""
    c, s = abs(math.cos(yaw)), abs(math.sin(yaw))
    reach_x = math.ceil((half_width * c + half_depth * s) / cell_m)
    reach_y = math.ceil((half_width * s + half_depth * c) / cell_m)
    y, x = np.mgrid[-reach_y : reach_y + 1, -reach_x : reach_x + 1] * cell_m
    along = x * math.cos(yaw) + y * math.sin(yaw)
    across = -x * math.sin(yaw) + y * math.cos(yaw)
    edge = cell_m / 2
    covered = (np.abs(along) < half_width + edge) & (np.abs(across) < half_depth + edge)
    stamp: UInt8 = covered.astype(np.uint8)
    return stamp


def _eroded(free: Bool, kernel: UInt8) -> Bool:
    """Return the cells around which the whole stamp is free; outside the grid nothing is."""
    if kernel.shape[0] > free.shape[0] or kernel.shape[1] > free.shape[1]:
        return np.zeros_like(free)
    fits: Bool = np.zeros_like(free)
    up, left = kernel.shape[0] // 2, kernel.shape[1] // 2
    inner = np.s_[up : free.shape[0] - up, left : free.shape[1] - left]
    fits[inner] = cv2.erode(free.astype(np.uint8), kernel)[inner] > 0
    return fits


def _height_below(level: Support, kernel: UInt8, row: int, column: int) -> float:
    """Return the highest point of a level under a stamp: what the thing comes to rest on."""
    up, left = kernel.shape[0] // 2, kernel.shape[1] // 2
    below = level.height[row - up : row + up + 1, column - left : column + left + 1]
    return float(below[kernel > 0].max())


def _world_pose(host: Thing, mesh: Mesh, centre: Float64, z: float, yaw: float) -> Float64:
    """Return the pose that puts the middle of a mesh's base on a point of its host."""
    low, high = bounds(mesh)
    T_host_thing = pose(float(centre[0]), float(centre[1]), z - float(low[2]), yaw)
    T_host_thing[:2, 3] -= T_host_thing[:2, :2] @ ((low + high) / 2)[:2]
    T_world: Float64 = host.T_world_thing @ T_host_thing
    return pose(float(T_world[0, 3]), float(T_world[1, 3]), float(T_world[2, 3]), yaw_of(T_world))
