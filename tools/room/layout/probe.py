"""Vertical rays through a mesh: where it is solid above each cell of a grid."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64, Int64
from sceneq_tools.room.mesh import Mesh

CELL_M = 0.01
"""Fine enough for the leg of a chair and the foot of a lamp."""

LEVEL_COSINE = 0.94
"""Faces within 20 degrees of level carry things without their sliding off."""


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Square cells over a rectangle of a mesh's own xy plane; cell (row, column) is (y, x)."""

    x: float
    y: float
    rows: int
    columns: int
    cell_m: float = CELL_M

    def centres(self) -> Float64:
        """Return the centre of every cell, (rows * columns, 2), row by row."""
        xs = self.x + (np.arange(self.columns) + 0.5) * self.cell_m
        ys = self.y + (np.arange(self.rows) + 0.5) * self.cell_m
        return np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """Every crossing of the grid's vertical rays with a mesh, sorted by cell, then upwards.

    Attributes:
        cell: flat index of the ray; z: metres; level: whether a thing could stand on such a face
            (models are not wound consistently, so up and down are not told apart).
    """

    cell: Int64
    z: Float64
    level: Bool


@lru_cache(maxsize=1024)
def bounds(mesh: Mesh) -> tuple[Float64, Float64]:
    """Return the lowest and highest corner of a mesh in its own frame."""
    vertices = mesh.vertices[np.unique(mesh.faces)].astype(np.float64)
    return vertices.min(0), vertices.max(0)


def grid_over(mesh: Mesh, cell_m: float = CELL_M) -> Grid:
    """Return the grid that covers a mesh."""
    low, high = bounds(mesh)
    columns, rows = np.maximum(np.ceil((high[:2] - low[:2]) / cell_m - 1e-6), 1).astype(int)
    return Grid(float(low[0]), float(low[1]), int(rows), int(columns), cell_m)


class Probe:
    """Ray casting into one mesh, in its own frame."""

    def __init__(self, mesh: Mesh) -> None:
        import open3d as o3d

        core: Any = o3d.core
        self._tensor = core.Tensor
        self._scene = o3d.t.geometry.RaycastingScene(nthreads=1)
        self._scene.add_triangles(
            self._tensor(np.ascontiguousarray(mesh.vertices, dtype=np.float32)),
            self._tensor(mesh.faces.astype(np.uint32)),
        )
        corners = mesh.vertices[mesh.faces].astype(np.float64)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.maximum(np.linalg.norm(normals, axis=1), 1e-15)
        self._steepness = np.abs(normals[:, 2]) / length
        self._top = float(mesh.vertices[:, 2].max()) + 1.0

    def crossings(self, grid: Grid) -> Hits:
        """Return every crossing of the vertical rays through the grid's cells."""
        points = grid.centres()
        origins = np.column_stack([points, np.full(len(points), self._top)])
        down = np.broadcast_to([0.0, 0.0, -1.0], origins.shape)
        rays = np.hstack([origins, down]).astype(np.float32)
        found = self._scene.list_intersections(self._tensor(rays))
        cell = found["ray_ids"].numpy().astype(np.int64)
        z = self._top - found["t_hit"].numpy().astype(np.float64)
        level = self._steepness[found["primitive_ids"].numpy()] > LEVEL_COSINE
        order = np.lexsort((z, cell))
        return Hits(cell[order], z[order], level[order])

    def first_hit(self, origins: Float64, direction: tuple[float, float, float]) -> Float32:
        """Return the distance to the first hit of parallel rays, (N,), infinite where none."""
        rays = np.hstack([origins, np.broadcast_to(direction, origins.shape)]).astype(np.float32)
        distance: Float32 = self._scene.cast_rays(self._tensor(rays))["t_hit"].numpy()
        return distance
