"""Where on a model other things can stand."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64, Int64
from sceneq_tools.room.layout.probe import Grid, Hits, Probe, bounds, grid_over
from sceneq_tools.room.mesh import Mesh

LEVEL_TOLERANCE_M = 0.006
"""A cushion or a duvet is uneven by this much and still carries."""

LEAST_AREA_M2 = 0.015
"""A postcard's; nothing worth asking about stands on less."""

LEAST_CLEARANCE_M = 0.06
"""The height of a cup; a lower gap holds nothing."""

SHEET_M = 0.012
"""Hits closer than this are the two sides of one sheet, or a veneer."""

FRONT_PROBE_M = 0.05
"""How far above a surface a hand comes in from the front."""


@dataclass(frozen=True, slots=True, eq=False)
class Support:
    """One level of a model that carries things.

    Attributes:
        grid: cells over the model's own xy plane.
        z: metres, the usual height of the level.
        height: float32 (rows, columns), the exact height of each cell, NaN where nothing carries.
        clearance: float32 (rows, columns), free height above each cell; infinite under the sky.
        covered: whether most of it lies under another part of the model, as in a shelf.
        sunken: whether the model's rim is well above it, as in a basin or a box.
    """

    grid: Grid
    z: float
    height: Float32
    clearance: Float32
    covered: bool
    sunken: bool

    @property
    def area_m2(self) -> float:
        """How much of it carries."""
        return float(np.isfinite(self.height).sum()) * self.grid.cell_m**2


@lru_cache(maxsize=512)
def supports(mesh: Mesh) -> tuple[Support, ...]:
    """Return the upward, free and reachable faces of a model, the highest first.

    A face is free when a cup fits above it, and reachable when nothing of the model is above it or
    it is open to the front (-y). Levels are looked for with vertical rays on a 1 cm grid.
    """
    probe = Probe(mesh)
    grid = grid_over(mesh)
    hits = _outermost(probe.crossings(grid))
    if not hits.z.size:
        return ()
    clearance = _clearance(hits)
    usable = hits.level & (clearance > LEAST_CLEARANCE_M)
    levels = []
    for z in _levels(hits.z[usable], grid.cell_m):
        near = usable & (np.abs(hits.z - z) <= LEVEL_TOLERANCE_M)
        level = _level(probe, grid, hits.cell[near], hits.z[near], clearance[near], z)
        if level is not None:
            levels.append(level)
    top = float(bounds(mesh)[1][2])
    return tuple(
        Support(grid, z, height, free, bool(np.isfinite(free).mean() > 0.5), top - z > 0.03)
        for z, height, free in sorted(levels, key=lambda level: -level[0])
    )


@lru_cache(maxsize=512)
def underneath(mesh: Mesh) -> Support | None:
    """Return the floor below a model, as far as it is free and can be reached from the front."""
    probe = Probe(mesh)
    grid = grid_over(mesh)
    points = grid.centres()
    floor = np.column_stack([points, np.full(len(points), 0.001)])
    free = probe.first_hit(floor, (0.0, 0.0, 1.0)).astype(np.float64)
    cells = np.flatnonzero(np.isfinite(free) & (free > LEAST_CLEARANCE_M)).astype(np.int64)
    level = _level(probe, grid, cells, np.zeros(len(cells)), free[cells], 0.0)
    if level is None:
        return None
    return Support(grid, 0.0, level[1], level[2], covered=True, sunken=True)


def _outermost(hits: Hits) -> Hits:
    """Keep the upper side of every sheet."""
    above = np.append(hits.z[1:] - hits.z[:-1], np.inf)
    above[:-1][hits.cell[1:] != hits.cell[:-1]] = np.inf
    keep = above > SHEET_M
    return Hits(hits.cell[keep], hits.z[keep], hits.level[keep])


def _clearance(hits: Hits) -> Float64:
    """Return for every crossing the distance to the next one above it."""
    above = np.full(len(hits.z), np.inf)
    same = hits.cell[1:] == hits.cell[:-1]
    above[:-1][same] = (hits.z[1:] - hits.z[:-1])[same]
    return above


def _levels(z: Float64, cell_m: float) -> list[float]:
    """Return the heights at which much of the model is level, the largest first."""
    if not z.size:
        return []
    cells = max(int(LEAST_AREA_M2 / cell_m**2), 1)
    step = 0.002
    counts = np.bincount(np.round((z - z.min()) / step).astype(int))
    levels: list[float] = []
    for peak in np.argsort(-counts, kind="stable"):
        centre = float(z.min() + peak * step)
        near = np.abs(z - centre) <= LEVEL_TOLERANCE_M
        if counts[peak] == 0 or counts[peak] * 8 < cells:
            break
        if near.sum() >= cells and all(abs(centre - known) > 0.02 for known in levels):
            levels.append(centre)
    return levels


def _level(
    probe: Probe, grid: Grid, cells: Int64, z: Float64, clearance: Float64, level: float
) -> tuple[float, Float32, Float32] | None:
    """Return height and clearance of a level's reachable cells; ``None`` when too few are."""
    reachable = ~np.isfinite(clearance)
    inner = np.flatnonzero(~reachable)
    hand = np.minimum(FRONT_PROBE_M, clearance[inner] / 2)
    origins = np.column_stack([grid.centres()[cells[inner]], z[inner] + hand])
    reachable[inner] = ~np.isfinite(probe.first_hit(origins, (0.0, -1.0, 0.0)))
    if reachable.sum() * grid.cell_m**2 < LEAST_AREA_M2:
        return None
    height = np.full(grid.rows * grid.columns, np.nan, np.float32)
    free = np.zeros(grid.rows * grid.columns, np.float32)
    height[cells[reachable]] = z[reachable]
    free[cells[reachable]] = clearance[reachable]
    shape = (grid.rows, grid.columns)
    return level, height.reshape(shape), free.reshape(shape)


def carries(support: Support) -> Bool:
    """Return the cells that carry, (rows, columns)."""
    return np.isfinite(support.height)
