"""Which neighbouring voxels are one smooth, evenly coloured piece of surface."""

from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np

from sceneq_core.arrays import Float32, Float64, Int32, Int64
from sceneq_core.checks import need_at_least, need_between, need_positive
from sceneq_core.mapping.cells import CELL_BITS, CELL_SIDE
from sceneq_core.mapping.rows import largest_of_runs, runs

_PADDED_SIDE = CELL_SIDE + 2
_STEPS = sorted(
    (abs(dx) + abs(dy) + abs(dz), (dx * _PADDED_SIDE + dy) * _PADDED_SIDE + dz)
    for dx, dy, dz in product((-1, 0, 1), repeat=3)
    if (dx, dy, dz) > (0, 0, 0)
)
_FACE_STEPS = [step for axes, step in _STEPS if axes == 1]
_CORNER_STEPS = [step for axes, step in _STEPS if axes > 1]
"""13 of the 26 neighbours as steps in a cell with an empty border, so no bounds are checked."""


@dataclass(frozen=True, slots=True)
class SuperpointParams:
    """Where neighbouring voxels are cut apart.

    ``max_angle_deg`` between their normals; ``max_colour`` in CIELAB units, lightness counted by
    half because shading changes it; parts under ``min_voxels`` join their most similar neighbour.
    A cell with little new surface is partitioned anew only every ``refresh_keyframes``-th time, and
    only when it was seen ``min_growth`` times as much as when it last was: means settle.
    """

    max_angle_deg: float = 25.0
    max_colour: float = 5.0
    min_voxels: int = 10
    refresh_keyframes: int = 4
    min_growth: float = 1.25

    def __post_init__(self) -> None:
        need_between(self, 0, 180, "max_angle_deg")
        need_positive(self, "max_colour")
        need_at_least(self, 1, "min_voxels", "refresh_keyframes", "min_growth")


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
    count = len(features.coord)
    if not count:
        return np.zeros(0, np.int32)
    neighbours = _Neighbours(features.coord)
    table = _comparable(features)
    # What hangs together by faces, which is most of it, need not be compared across corners.
    faces = _compare(table, *neighbours.pairs(_FACE_STEPS), params)
    part = _components(faces.similar, count)
    first, second = neighbours.pairs(_CORNER_STEPS)
    apart = np.flatnonzero(part.take(first) != part.take(second))
    corners = _compare(table, first.take(apart), second.take(apart), params)
    part = _unite(part, corners.similar)
    return _join_small(part, (faces, corners), params.min_voxels)


@dataclass(frozen=True, slots=True)
class _Compared:
    """Pairs of voxels (2, E): the ``similar``, and the ``different`` with the cost of a join."""

    similar: Int32
    different: Int32
    cost: Float32


class _Neighbours:
    """The pairs of 26-neighbours that share a cell."""

    def __init__(self, coord: Int32) -> None:
        first, of_voxel = runs(coord >> CELL_BITS)
        local = (coord & (CELL_SIDE - 1)) + 1
        place = (of_voxel.astype(np.int32) * _PADDED_SIDE + local[:, 0]) * _PADDED_SIDE
        self._place = (place + local[:, 1]) * _PADDED_SIDE + local[:, 2]
        # One more than the row, 0 = none: zeroed memory is quicker to have than filled memory.
        self._row_at = np.zeros(len(first) * _PADDED_SIDE**3, np.int32)
        self._row_at[self._place] = np.arange(1, len(coord) + 1, dtype=np.int32)

    def pairs(self, steps: list[int]) -> tuple[Int32, Int32]:
        """Return the rows, each int32 (E,), of the voxels that are one of ``steps`` apart."""
        sources, targets = [], []
        for step in steps:
            target = self._row_at.take(self._place + np.int32(step))
            source = np.flatnonzero(target != 0)
            sources.append(source.astype(np.int32))
            targets.append(target.take(source) - 1)
        return np.concatenate(sources), np.concatenate(targets)


def _comparable(features: VoxelFeatures) -> Float32:
    """Return the normal and the colour (half lightness, a, b) of each voxel, float32 (6, N)."""
    lab = cv2.cvtColor(np.ascontiguousarray(features.colours)[None], cv2.COLOR_RGB2LAB)[0]
    table = np.empty((6, len(lab)), np.float32)
    table[:3], table[3:] = features.normals_world.T, lab.T
    table[3] *= np.float32(0.5)
    return table


def _compare(table: Float32, first: Int32, second: Int32, params: SuperpointParams) -> _Compared:
    """Tell similar from different pairs by the angle of the normals and the colour distance."""
    n = [row.take(first) * row.take(second) for row in table[:3]]
    c = [(row.take(first) - row.take(second)) ** 2 for row in table[3:]]
    cosine, square = n[0] + n[1] + n[2], c[0] + c[1] + c[2]
    alike = (cosine > np.cos(np.deg2rad(params.max_angle_deg))) & (square < params.max_colour**2)
    similar, different = np.flatnonzero(alike), np.flatnonzero(~alike)
    cost = (1 - cosine.take(different)) + np.sqrt(square.take(different)) / 100
    return _Compared(_columns(first, second, similar), _columns(first, second, different), cost)


def _columns(first: Int32, second: Int32, row: Int64) -> Int32:
    return np.stack((first.take(row), second.take(row)))


def _unite(part: Int32, pairs: Int32) -> Int32:
    """Return parts dense from 0 with those that hold the two of a pair made one."""
    joined = _components(part.take(pairs), int(part.max()) + 1)
    return joined.take(part)


def _components(pairs: Int32, count: int) -> Int32:
    """Return the component int32 (count,), dense from 0, of each of ``count`` linked things."""
    root = np.arange(count, dtype=np.int32)
    while pairs.shape[1]:
        further = _linked(pairs, count)
        root, pairs = further.take(root), further.take(pairs)
        pairs = pairs.compress(pairs[0] != pairs[1], axis=1)
    return _dense(root)


def _linked(pairs: Int32, count: int) -> Int32:
    """Return for each thing the end of the chain of links that begins at it.

    A thing is linked to one of its pairs that is larger, so no chain is a circle.
    """
    end = np.arange(count, dtype=np.int32)
    end[np.minimum(pairs[0], pairs[1])] = np.maximum(pairs[0], pairs[1])
    while True:
        further = end.take(end)
        if np.array_equal(further, end):
            return end
        end = further


def _dense(label: Int32) -> Int32:
    """Return labels renumbered from 0 in the order of their numbers."""
    used = np.bincount(label) > 0
    number: Int32 = (np.cumsum(used) - 1).astype(np.int32)
    return number.take(label)


def _join_small(part: Int32, compared: tuple[_Compared, ...], min_voxels: int) -> Int32:
    """Let every small part join the neighbouring part it differs least from on average."""
    small = np.bincount(part) < min_voxels
    links = []
    for one in compared:
        a, b = part.take(one.different)
        leaving, back = (np.flatnonzero((a != b) & small.take(end)) for end in (a, b))
        links.append((a.take(leaving), b.take(leaving), one.cost.take(leaving)))
        links.append((b.take(back), a.take(back), one.cost.take(back)))
    source, target, cost = (np.concatenate(column) for column in zip(*links, strict=True))
    joined = _components(_cheapest_target(source, target, cost, len(small)), len(small))
    return joined.take(part)


def _cheapest_target(source: Int32, target: Int32, cost: Float32, count: int) -> Int32:
    """Return the pairs (2, S) of each source with the target that costs it least on average."""
    pair, row = np.unique(source * np.int64(count) + target, return_inverse=True)
    mean = np.bincount(row, cost) / np.bincount(row)
    source, target = (pair // count).astype(np.int32), (pair % count).astype(np.int32)
    cheapest = largest_of_runs(source, -mean)
    return np.stack((source[cheapest], target[cheapest]))
