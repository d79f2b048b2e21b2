"""Boxes round a set of points, one edge along gravity."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from sceneq_core.arrays import Float32, Float64

_RECTANGLE_POINTS = 4096


@dataclass(frozen=True, slots=True)
class Box:
    """An axis-aligned and an oriented box, metres, world frame: the fields of ``Instance``."""

    centre_world: Float64
    aabb_world: Float64
    T_world_box: Float64
    box_size_m: Float64


def box_around(points_world: Float32, up_world: Float64) -> Box:
    """Return the boxes of ``points_world`` float32 (N, 3), N > 0.

    The oriented box has z along ``up_world`` and x along its longer horizontal edge; its
    horizontal rectangle has the smallest area (rotating calipers).
    """
    columns = np.ascontiguousarray(points_world.T, np.float64)
    centre = columns.mean(axis=1)
    R_world_level = level_axes(up_world)
    level = R_world_level.T @ (columns - centre[:, None])
    # A stride over many points shrinks the rectangle by less than the spacing of the points.
    sample = level[:2, :: 1 + level.shape[1] // _RECTANGLE_POINTS].T
    rectangle = cv2.minAreaRect(np.ascontiguousarray(sample, np.float32))
    (middle_x, middle_y), (length, width), angle_deg = rectangle
    if width > length:
        length, width, angle_deg = width, length, angle_deg + 90.0
    low, high = float(level[2].min()), float(level[2].max())
    T_world_box = np.eye(4)
    T_world_box[:3, :3] = R_world_level @ _turn(np.deg2rad(angle_deg))
    T_world_box[:3, 3] = centre + R_world_level @ [middle_x, middle_y, (low + high) / 2.0]
    return Box(
        centre_world=centre,
        aabb_world=np.stack((columns.min(axis=1), columns.max(axis=1))),
        T_world_box=T_world_box,
        box_size_m=np.array([length, width, high - low]),
    )


def level_axes(up_world: Float64) -> Float64:
    """Return a rotation (3, 3), not to be written to, whose third column is ``up_world``."""
    return _level_axes(np.asarray(up_world, np.float64).tobytes())


@lru_cache(maxsize=16)  # up is the same for all boxes of a keyframe
def _level_axes(up_bytes: bytes) -> Float64:
    up_world = np.frombuffer(up_bytes, np.float64)
    helper = np.eye(3)[int(np.argmin(np.abs(up_world)))]
    x = _cross(helper, up_world)
    x /= np.sqrt(x @ x)
    axes = np.stack((x, _cross(up_world, x), up_world), axis=1)
    axes.flags.writeable = False
    return axes


def _cross(a: Float64, b: Float64) -> Float64:
    """Return a x b; for single vectors ten times quicker than ``np.cross``."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def _turn(angle: float) -> Float64:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
