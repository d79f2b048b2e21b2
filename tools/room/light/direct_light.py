"""Light that comes straight from the lights: soft shadows."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32, Int32
from sceneq_tools.room.light.jitter import jitter
from sceneq_tools.room.light.raycaster import Raycaster
from sceneq_tools.room.light.stage import Points
from sceneq_tools.room.room import Light

LIFT_M = 0.002  # rays start this far above the surface they light
NEAREST_M = 0.1  # light counts as no nearer than this: the sum over so few points would be noise


@dataclass(frozen=True, slots=True, eq=False)
class Receivers:
    """Places that light falls on: one side of a surface each.

    Attributes: float32 (N, 3) ``positions`` (lifted off the surface) and ``normals`` (to the side
    that is lit), and float32 (N, 2) ``jitter`` in 0..1.
    """

    positions: Float32
    normals: Float32
    jitter: Float32


def receivers(points: Points, index: Int32, side: int, seed: int) -> Receivers:
    """Return the front (``side`` 0) or back (1) of the points with these indices."""
    normals = points.normals[index] * np.float32(1 - 2 * side)
    positions = points.positions[index] + normals * np.float32(LIFT_M)
    thing_id, number = points.thing_id[index], points.number[index]
    shifts = [jitter(seed, thing_id, number, 2 * side + axis) for axis in range(2)]
    return Receivers(positions, normals, np.stack(shifts, axis=1))


def direct_light(
    to: Receivers, light: Light, raycaster: Raycaster, rays: int
) -> tuple[Float32, Float32]:
    """Return per receiver the irradiance of a light of radiance 1 and the share of it that is seen.

    One ray goes to each of several equal cells of the rectangle. Both float32 (N,).
    """
    cells = _strata(light, rays)
    arriving, seen = (np.zeros(len(to.positions), np.float32) for _ in range(2))
    for cell in cells:
        form, free = _look(to, light, cell, raycaster)
        arriving += form * free
        seen += free
    share = np.float32(1 / len(cells))
    return arriving * share, seen * share


def _strata(light: Light, rays: int) -> Float32:
    """Return (N, 4): corner and size of about ``rays`` cells that are nearly square."""
    across = np.linalg.norm(light.edge_u) / max(float(np.linalg.norm(light.edge_v)), 1e-6)
    columns = int(np.clip(round(np.sqrt(rays * across)), 1, rays))
    rows = max(1, round(rays / columns))
    u, v = np.meshgrid(np.arange(columns) / columns, np.arange(rows) / rows)
    size = np.broadcast_to([1 / columns, 1 / rows], (u.size, 2))
    return np.column_stack([u.ravel(), v.ravel(), size]).astype(np.float32)


def _look(
    to: Receivers, light: Light, cell: Float32, raycaster: Raycaster
) -> tuple[Float32, Float32]:
    """Return geometry factor times the light's area, and 1 where this point of it is seen."""
    share = cell[:2] + to.jitter * cell[2:]
    edges = np.stack([light.edge_u, light.edge_v]).astype(np.float32)
    ray = (light.corner + share @ edges - to.positions).astype(np.float32)
    area_normal = np.cross(light.edge_u, light.edge_v).astype(np.float32)  # as long as the area
    squared = np.maximum(np.einsum("ij,ij->i", ray, ray), np.float32(NEAREST_M**2))
    leaving = -(ray @ area_normal)
    arriving = np.einsum("ij,ij->i", ray, to.normals)
    form = np.maximum(leaving, 0) * np.maximum(arriving, 0) / squared**2
    seen = np.zeros(len(ray), np.float32)
    facing = np.flatnonzero(form > 0)
    seen[facing] = ~raycaster.occluded(to.positions[facing], ray[facing])
    return form, seen
