"""Points of a surface where light is measured, and places that read it from them."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from sceneq_core.arrays import Float32, Float64, Int32, Int64
from sceneq_tools.room.mesh import Mesh

NEIGHBOURS = 6  # points that a place reads; the farthest of them has next to no weight
SMOOTHED = 12  # the same when points read each other, to even out the noise of few rays
SCRAP = 0.25  # a face of less than this share of the largest in its cell does not stand for it
NORMAL_WEIGHT = 1.5  # a right angle between normals is as far as about two cells


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """Distinct positions with distinct normals: N of them, float32 (N, 3) both."""

    positions: Float32
    normals: Float32


@dataclass(frozen=True, slots=True, eq=False)
class SamplePoints:
    """One point for each cell of space and rough direction that the surface has.

    Attributes:
        at: P places on the surface, in the frame of the mesh.
        of_face: int32 (F,) the point that stands for the face.
        blend: sparse float32 (N, P), rows sum to one: the value at a place from those at points.
        smoothing: sparse float32 (P, P), the same for the points themselves.
    """

    at: Places
    of_face: Int32
    blend: Any
    smoothing: Any


def sample_points(mesh: Mesh, cell_m: float, places: Places) -> SamplePoints:
    """Choose one face of each cell; points are centres of faces, clear of all edges."""
    centres, area = _face_centres(mesh)
    keys = cell_keys(centres, cell_m)
    outermost_first = np.lexsort((-_prominence(centres, area, keys), keys))
    _, first, of_face = np.unique(keys[outermost_first], return_index=True, return_inverse=True)
    of_face[outermost_first] = of_face.copy()
    chosen = outermost_first[first]
    points = Places(centres.positions[chosen], centres.normals[chosen])
    return SamplePoints(
        points,
        of_face.astype(np.int32),
        _reading(places, points, cell_m, NEIGHBOURS),
        _reading(points, points, cell_m, SMOOTHED),
    )


def distinct_places(mesh: Mesh, cell_m: float) -> tuple[Places, Int32]:
    """Return one place for all vertices in a cell that face one way, and that of each corner.

    The second is int32 (F, 3). Dense meshes have far more vertices than light has detail.
    """
    vertices = Places(mesh.vertices, mesh.normals)
    keys = cell_keys(vertices, cell_m)
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    places = Places(mesh.vertices[first], mesh.normals[first])
    return places, inverse.reshape(-1).astype(np.int32)[mesh.faces]


def cell_keys(places: Places, cell_m: float) -> Int64:
    """Return one integer for each cell of space and rough direction."""
    place = np.floor((places.positions - places.positions.min(axis=0)) / cell_m).astype(np.int64)
    direction = np.clip(np.round(places.normals * 1.4).astype(np.int64) + 1, 0, 2)
    key = np.zeros(len(place), np.int64)
    for part in (*place.T, *direction.T):
        key = key * (int(part.max()) + 1) + part
    return key


def _face_centres(mesh: Mesh) -> tuple[Places, Float64]:
    corners = mesh.vertices[mesh.faces]
    normals = mesh.normals[mesh.faces].sum(axis=1)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1).astype(np.float64)
    unit = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return Places(corners.mean(axis=1), unit.astype(np.float32)), area


def _prominence(centres: Places, area: Float64, keys: Int64) -> Float64:
    """Rank faces of one cell: of layers behind one another the outermost is the one seen."""
    _, cell = np.unique(keys, return_inverse=True)
    largest = np.zeros(int(cell.max(initial=-1)) + 1)
    np.maximum.at(largest, cell, area)
    outwards = np.einsum("ij,ij->i", centres.positions, centres.normals).astype(np.float64)
    return np.where(area >= SCRAP * largest[cell], outwards, -np.inf)


def _reading(readers: Places, points: Places, cell_m: float, neighbours: int) -> Any:
    """Weights that fall to zero at the last neighbour, so that nothing jumps where it changes."""
    from scipy.sparse import csr_matrix
    from scipy.spatial import cKDTree

    count = min(neighbours, len(points.positions))
    tree = cKDTree(_coordinates(points, cell_m))
    distance, nearest = tree.query(_coordinates(readers, cell_m), k=np.arange(1, count + 1))
    reach = distance[:, -1:] * 1.001 + 1e-6
    weight = (1 - distance / reach) ** 2 + 1e-6
    weight /= weight.sum(axis=1, keepdims=True)
    rows = np.arange(0, nearest.size + 1, count)
    shape = (len(readers.positions), len(points.positions))
    return csr_matrix((weight.astype(np.float32).ravel(), nearest.ravel(), rows), shape=shape)


def _coordinates(places: Places, cell_m: float) -> Float32:
    return np.hstack([places.positions / np.float32(cell_m), places.normals * NORMAL_WEIGHT])
