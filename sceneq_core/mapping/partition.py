"""Which neighbouring voxels are one smooth, evenly coloured piece of surface."""

from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64, Int32, Int64
from sceneq_core.checks import need_at_least, need_between, need_positive
from sceneq_core.mapping.cells import CELL_BITS, CELL_SIDE
from sceneq_core.mapping.rows import first_of_each
from sceneq_core.mapping.voxel_index import pack_coord

_PADDED_SIDE = CELL_SIDE + 2
_HALF_NEIGHBOURS = [
    (dx * _PADDED_SIDE + dy) * _PADDED_SIDE + dz
    for dx, dy, dz in product((-1, 0, 1), repeat=3)
    if (dx, dy, dz) > (0, 0, 0)
]
"""13 of the 26 neighbours as steps in a cell with an empty border, so no bounds are checked."""


@dataclass(frozen=True, slots=True)
class SuperpointParams:
    """Where neighbouring voxels are cut apart.

    ``max_angle_deg`` between their normals; ``max_colour`` in CIELAB units, lightness counted by
    half because shading changes it; parts under ``min_voxels`` join their most similar neighbour.
    A cell with little new surface is partitioned anew only every ``refresh_keyframes``-th time.
    """

    max_angle_deg: float = 25.0
    max_colour: float = 8.0
    min_voxels: int = 10
    refresh_keyframes: int = 4

    def __post_init__(self) -> None:
        need_between(self, 0, 180, "max_angle_deg")
        need_positive(self, "max_colour")
        need_at_least(self, 1, "min_voxels", "refresh_keyframes")


@dataclass(frozen=True, slots=True)
class VoxelFeatures:
    """What the partition looks at; parallel rows, those of one cell together.

    ``coord`` int32 (N, 3); ``normals_world`` float64 (N, 3) unit or zero; ``colours`` float32
    (N, 3) RGB in 0..1.
    """

    coord: Int32
    normals_world: Float64
    colours: Float32


def partition(features: VoxelFeatures, params: SuperpointParams) -> Int32:
    """Return the part int32 (N,) of every voxel, dense from 0; no part crosses a cell.

    A pure function of each cell's voxels, whatever else is in ``features``: so a map updated cell
    by cell equals one partitioned at once.
    """
    if not len(features.coord):
        return np.zeros(0, np.int32)
    edges = _edges_within_cells(features.coord)
    cosine, distance = _compare(features, edges)
    similar = (cosine > np.cos(np.deg2rad(params.max_angle_deg))) & (distance < params.max_colour)
    part = _components(edges[:, similar], len(features.coord))
    cost = (1.0 - cosine) + distance / 100.0
    return _join_small(part, edges[:, ~similar], cost[~similar], params.min_voxels)


def _compare(features: VoxelFeatures, edges: Int64) -> tuple[Float32, Float32]:
    """Return the cosine between the normals and the colour distance along each edge."""
    lab = _half_lightness_lab(features.colours)
    table = np.concatenate((features.normals_world.astype(np.float32), lab), axis=1)
    first, second = table.take(edges[0], axis=0), table.take(edges[1], axis=0)
    cosine = np.einsum("ij,ij->i", first[:, :3], second[:, :3])
    step = first[:, 3:] - second[:, 3:]
    return cosine, np.sqrt(np.einsum("ij,ij->i", step, step))


def _half_lightness_lab(colours: Float32) -> Float32:
    lab = cv2.cvtColor(np.ascontiguousarray(colours)[None], cv2.COLOR_RGB2LAB)[0]
    scaled: Float32 = lab * np.array([0.5, 1.0, 1.0], np.float32)
    return scaled


def _edges_within_cells(coord: Int32) -> Int64:
    """Return the pairs (2, E) of 26-neighbours that share a cell."""
    cell = pack_coord(coord >> CELL_BITS)
    cell_row = np.cumsum(np.concatenate(([False], cell[1:] != cell[:-1])))
    local = (coord & (CELL_SIDE - 1)).astype(np.int64) + 1
    place = (cell_row * _PADDED_SIDE + local[:, 0]) * _PADDED_SIDE + local[:, 1]
    place = place * _PADDED_SIDE + local[:, 2]
    node_at = np.full((int(cell_row[-1]) + 1) * _PADDED_SIDE**3, -1, np.int32)
    node_at[place] = np.arange(len(coord), dtype=np.int32)
    target = np.stack([node_at[place + step] for step in _HALF_NEIGHBOURS])
    step_row, source = np.nonzero(target >= 0)
    return np.stack((source, target[step_row, source]))


def _components(edges: Int64, count: int) -> Int32:
    # Imported here because it takes half of the start-up time of a process that maps.
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    ones = np.ones(edges.shape[1], np.bool_)
    graph = coo_matrix((ones, (edges[0], edges[1])), shape=(count, count))
    label: Int32 = connected_components(graph, directed=False)[1]
    return label.astype(np.int32)


def _join_small(part: Int32, edges: Int64, cost: Float32, min_voxels: int) -> Int32:
    """Let every small part join the neighbouring part it differs least from on average."""
    a, b = part[edges[0]].astype(np.int64), part[edges[1]].astype(np.int64)
    across = a != b
    a, b, cost = a[across], b[across], cost[across]
    count = int(part.max()) + 1
    small = np.bincount(part, minlength=count) < min_voxels
    source, target = np.concatenate((a, b)), np.concatenate((b, a))
    cost = np.concatenate((cost, cost))
    best = _cheapest_target(source, target, cost, small, count)
    joined = _components(best, count)
    return joined[part]


def _cheapest_target(source: Int64, target: Int64, cost: Float32, small: Bool, count: int) -> Int64:
    leaving = small[source]
    pair, row = np.unique(source[leaving] * count + target[leaving], return_inverse=True)
    mean = np.bincount(row, cost[leaving]) / np.bincount(row)
    source, target = pair // count, pair % count
    cheapest = first_of_each(np.lexsort((target, mean, source)), source)
    return np.stack((source[cheapest], target[cheapest]))
