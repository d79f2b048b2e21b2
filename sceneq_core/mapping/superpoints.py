"""Over-segmentation of the voxels by normal and colour, cell by cell."""

from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64, Int32, Int64
from sceneq_core.mapping.cells import CELL_BITS, CELL_SIDE
from sceneq_core.mapping.growing import distinct, marked, with_rows
from sceneq_core.mapping.voxel_index import pack_coord
from sceneq_core.mapping.voxels import Voxels

_PADDED_SIDE = CELL_SIDE + 2
_HALF_NEIGHBOURS = [
    (dx * _PADDED_SIDE + dy) * _PADDED_SIDE + dz
    for dx, dy, dz in product((-1, 0, 1), repeat=3)
    if (dx, dy, dz) > (0, 0, 0)
]
"""13 of the 26 neighbours as steps in a cell with an empty border, so no bounds are checked."""

_MUCH_NEW = 8
"""A cell has gained much surface when this many times the new voxels exceed those seen."""


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
        if not 0.0 < self.max_angle_deg < 180.0:
            raise ValueError(f"max_angle_deg: must be in 0..180, got {self.max_angle_deg}")
        if self.max_colour <= 0.0:
            raise ValueError(f"max_colour: must be positive, got {self.max_colour}")
        if self.min_voxels < 1:
            raise ValueError(f"min_voxels: must be at least 1, got {self.min_voxels}")
        if self.refresh_keyframes < 1:
            raise ValueError(f"refresh_keyframes: must be at least 1: {self.refresh_keyframes}")


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
    order = np.lexsort((target, mean, source))
    first = np.unique(source[order], return_index=True)[1]
    return np.stack((source[order][first], target[order][first]))


@dataclass(frozen=True, slots=True)
class SuperpointChange:
    """What an update did: ``new_id`` came out of ``parent_id`` (-1 = from nothing), ``gone_id``."""

    new_id: Int32
    parent_id: Int32
    gone_id: Int32


class Superpoints:
    """The superpoint of every voxel; an id stays with the part that keeps most of its voxels.

    Ids of vanished superpoints are given again, so tables by id stay as small as the surface.
    """

    def __init__(self, params: SuperpointParams) -> None:
        self._params = params
        self._of_voxel = np.full(0, -1, np.int32)
        self._cell = np.full(0, -1, np.int32)
        self._free: list[int] = []
        self._count = 0

    def __len__(self) -> int:
        """Return one more than the largest id given so far."""
        return self._count

    def of(self, voxel_id: Int32) -> Int32:
        """Return the superpoint ids of voxels, -1 = none."""
        return self._of_voxel[voxel_id]

    def voxels(self, voxels: Voxels, superpoint_id: Int32) -> Int32:
        """Return the voxels of these superpoints, in the order of their cells."""
        wanted = marked(superpoint_id, len(self))
        inside = voxels.cells.voxels(distinct(self._cell[superpoint_id], len(voxels.cells)))
        superpoint = self._of_voxel[inside]
        return inside[(superpoint >= 0) & wanted[superpoint]]

    def update(
        self, voxels: Voxels, touched_id: Int32, cleared_id: Int32, keyframe: int
    ) -> tuple[Int32, SuperpointChange]:
        """Partition cells of these voxels anew; return the voxels partitioned and the change."""
        self._of_voxel = with_rows(self._of_voxel, len(voxels), -1)
        cell_id = self._due_cells(voxels, touched_id, cleared_id, keyframe)
        inside = voxels.cells.voxels(cell_id)
        before = self._of_voxel[inside]
        before = distinct(before[before >= 0], len(self))
        self._of_voxel[cleared_id] = -1
        voxel_id = voxels.occupied(inside)
        part = partition(
            VoxelFeatures(
                voxels.coord(voxel_id), voxels.normals_world(voxel_id), voxels.colours(voxel_id)
            ),
            self._params,
        )
        change = self._rename(voxel_id, part, before)
        self._cell = with_rows(self._cell, len(self), -1)
        self._cell[self._of_voxel[voxel_id]] = voxels.cells.of(voxels.coord(voxel_id))
        return voxel_id, change

    def _due_cells(
        self, voxels: Voxels, touched_id: Int32, cleared_id: Int32, keyframe: int
    ) -> Int32:
        """Return the touched cells that lost surface, gained much of it, or whose turn it is."""
        cell = voxels.cells.of(voxels.coord(touched_id))
        count = len(voxels.cells)
        new = np.bincount(cell[self._of_voxel[touched_id] < 0], minlength=count)
        touched = np.bincount(cell, minlength=count)
        turn = (np.arange(count) + keyframe) % self._params.refresh_keyframes == 0
        due = (touched > 0) & (turn | (_MUCH_NEW * new > touched))
        due[voxels.cells.of(voxels.coord(cleared_id))] = True
        return np.flatnonzero(due).astype(np.int32)

    def _rename(self, voxel_id: Int32, part: Int32, before: Int32) -> SuperpointChange:
        heir, parent = _match(part, self._of_voxel[voxel_id])
        gone = before[~marked(heir[heir >= 0], len(self))[before]]
        new = heir < 0
        new_id = self._take_ids(int(new.sum()))
        heir[new] = new_id
        self._of_voxel[voxel_id] = heir[part]
        self._free = sorted(self._free + gone.tolist(), reverse=True)
        return SuperpointChange(new_id, parent[new], gone)

    def _take_ids(self, count: int) -> Int32:
        again = [self._free.pop() for _ in range(min(count, len(self._free)))]
        fresh = range(self._count, self._count + count - len(again))
        self._count += len(fresh)
        return np.array([*again, *fresh], np.int32)


def _match(part: Int32, old: Int32) -> tuple[Int32, Int32]:
    """Return per part the old id it keeps (or -1) and the old id it overlaps most (or -1).

    A part keeps an old id when each is the other's largest overlap.
    """
    count = int(part.max(initial=-1)) + 1
    heir, parent = np.full(count, -1, np.int32), np.full(count, -1, np.int32)
    known = old >= 0
    span = int(old.max(initial=0)) + 1
    pair, overlap = np.unique(part[known] * np.int64(span) + old[known], return_counts=True)
    pair_part, pair_old = pair // span, pair % span
    largest_old = _first_of_each(np.lexsort((pair_old, -overlap, pair_part)), pair_part)
    largest_part = _first_of_each(np.lexsort((pair_part, -overlap, pair_old)), pair_old)
    parent[pair_part[largest_old]] = pair_old[largest_old]
    mutual = np.intersect1d(largest_old, largest_part)
    heir[pair_part[mutual]] = pair_old[mutual]
    return heir, parent


def _first_of_each(order: Int64, key: Int64) -> Int64:
    """Return the rows of ``order`` that come first for their key."""
    return order[np.unique(key[order], return_index=True)[1]]
