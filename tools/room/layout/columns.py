"""A mesh as solid columns: what it takes of the air above every cell of the floor."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64
from sceneq_tools.room.layout.probe import CELL_M, Grid, Probe, grid_over
from sceneq_tools.room.mesh import Mesh


@dataclass(frozen=True, slots=True, eq=False)
class Columns:
    """The lowest and highest solid point above each cell, in the mesh's own frame.

    Thin parts may fall between two rays, so every cell also answers for its neighbours.

    Attributes:
        grid: the cells.
        low: float32 (rows, columns), ``inf`` where empty; ``high``: ``-inf`` where empty.
    """

    grid: Grid
    low: Float32
    high: Float32


@lru_cache(maxsize=1024)
def columns(mesh: Mesh) -> Columns:
    """Return the solid columns of a mesh."""
    grid = _with_rim(grid_over(mesh, CELL_M))
    hits = Probe(mesh).crossings(grid)
    low = np.full(grid.rows * grid.columns, np.inf)
    high = np.full(grid.rows * grid.columns, -np.inf)
    np.minimum.at(low, hits.cell, hits.z)
    np.maximum.at(high, hits.cell, hits.z)
    shape, around = (grid.rows, grid.columns), np.ones((3, 3), np.uint8)
    lowest = cv2.erode(low.reshape(shape).astype(np.float32), around)
    highest = cv2.dilate(high.reshape(shape).astype(np.float32), around)
    return Columns(grid, lowest.astype(np.float32), highest.astype(np.float32))


def _with_rim(grid: Grid) -> Grid:
    """Return the grid with one more cell on every side, so that neighbours have a place."""
    step = grid.cell_m
    return Grid(grid.x - step, grid.y - step, grid.rows + 2, grid.columns + 2, step)


@lru_cache(maxsize=1024)
def solid_points(mesh: Mesh) -> Float64:
    """Return the middle of every filled cell with its column, (N, 4): x, y, low, high."""
    solid = columns(mesh)
    filled = np.isfinite(solid.low)
    xy = solid.grid.centres()[filled.reshape(-1)]
    return np.column_stack([xy, solid.low[filled], solid.high[filled]])


def taken(mesh: Mesh, points: Float64, low: Float64, high: Float64) -> Bool:
    """Tell which vertical segments meet the solid columns of a mesh, all in its own frame.

    Args:
        mesh: the mesh.
        points: (N, 2) where the segments are.
        low: (N,) their lower ends; ``high``: their upper ends.
    """
    solid = columns(mesh)
    grid = solid.grid
    cell = np.floor((points - (grid.x, grid.y)) / grid.cell_m).astype(np.int64)
    size = np.array([grid.columns, grid.rows])
    inside = np.all((cell >= 0) & (cell < size), axis=1)
    column, row = np.where(inside[:, None], cell, 0).T
    met = (solid.low[row, column] < high) & (solid.high[row, column] > low)
    answer: Bool = inside & met
    return answer
