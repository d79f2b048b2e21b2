"""What to leave out of a picture of a room so that one can look into it."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float64, Int64

CELL_M = 0.1
NEAR_M, FAR_M = 0.3, 1.5
OUTSIDE_SHARE = 0.2
SPECK_M = 0.1
SPECK_POINTS = 8


@dataclass(frozen=True, slots=True)
class CutawayParams:
    """Heights over the floor in metres.

    Attributes:
        ceiling_m: shell points above are left out; rooms are higher, most furniture is not.
        floor_m: shell points below stay in any view.
    """

    ceiling_m: float = 2.1
    floor_m: float = 0.15


def height_m(points_room: Float64) -> Float64:
    """Return heights (N,) over the floor, the lowest level of the points (N, 3), z up."""
    z = points_room[:, 2]
    height: Float64 = z - np.percentile(z, 1)
    return height


def below_ceiling(
    points_room: Float64, is_shell: Bool, params: CutawayParams | None = None
) -> Bool:
    """Return which points (N,) of a room stay when the ceiling is taken off.

    Args:
        points_room: (N, 3) metres, z up.
        is_shell: (N,) whether a point is of wall, floor, ceiling or nothing in particular;
            a lamp on the ceiling stays.
        params: heights.
    """
    params = params or CutawayParams()
    return ~(is_shell & (height_m(points_room) > params.ceiling_m))


def open_towards(
    points_room: Float64, is_shell: Bool, azimuth_deg: float, params: CutawayParams | None = None
) -> Bool:
    """Return which points (N,) stay when the walls on the camera's side are taken away.

    A wall is between the camera and the room where nothing was seen behind it, going from it
    towards the camera; the same wall on the far side has the room there.
    """
    params = params or CutawayParams()
    towards = np.array([np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg))])
    hides = _has_outside(points_room[:, :2], towards) & (height_m(points_room) > params.floor_m)
    return ~(is_shell & hides)


def without_specks(points_room: Float64, is_loose: Bool) -> Bool:
    """Return which points (N,) stay when loose ones with next to no company are left out.

    Along the edges of things depth is noisy: such points are of no instance and stand alone.
    """
    cell = np.floor(points_room[is_loose] / SPECK_M).astype(np.int64)
    _, where, count = np.unique(cell, axis=0, return_inverse=True, return_counts=True)
    kept = np.ones(len(points_room), np.bool_)
    kept[is_loose] = count[where.ravel()] >= SPECK_POINTS
    return kept


def _has_outside(plan: Float64, towards: Float64) -> Bool:
    """Tell for each point of the plan (N, 2) whether next to nothing lies ``towards`` there."""
    cell = np.floor((plan - plan.min(axis=0)) / CELL_M).astype(np.int64)
    border = int(FAR_M / CELL_M) + 2
    seen = _occupancy(cell + border, border)
    steps = np.arange(NEAR_M, FAR_M, CELL_M) / CELL_M
    hits = np.zeros(len(plan))
    for step in steps:
        u, v = (cell + border + np.rint(step * towards).astype(np.int64)).T
        hits += seen[u, v]
    outside: Bool = hits <= OUTSIDE_SHARE * len(steps)
    return outside


def _occupancy(cell: Int64, border: int) -> Bool:
    counts = np.zeros(cell.max(axis=0) + border + 1, np.float32)
    np.add.at(counts, (cell[:, 0], cell[:, 1]), 1.0)
    closed = cv2.morphologyEx(
        (counts >= 2).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)
    )
    occupied: Bool = closed > 0
    return occupied
