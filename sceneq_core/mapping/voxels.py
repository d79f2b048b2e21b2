"""The surface of the scene as running means in small cubes."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Array, Float32, Float64, Int32, Int64, UInt8
from sceneq_core.mapping.cells import SLOT_BITS, Cells
from sceneq_core.mapping.rows import distinct, first_of_each, put_rows, with_rows
from sceneq_core.mapping.surface import SurfacePoints
from sceneq_core.mapping.voxel_index import COORD_LIMIT
from sceneq_core.vectors import divided, unit_rows

_WEIGHT, _POSITION, _NORMAL, _COLOUR = 0, slice(1, 4), slice(4, 7), slice(7, 10)
_SUMS = 10
"""Columns of the table of sums; all of a voxel lies together, because it is read together."""


@dataclass(frozen=True, slots=True)
class Touched:
    """The voxels one surface fell into.

    ``voxel_id`` int32 (M,) distinct, sorted; ``of_point`` int32 (N,) the row in it of every point;
    ``new_id`` int32 those of ``voxel_id`` that had never been touched before.
    """

    voxel_id: Int32
    of_point: Int32
    new_id: Int32


@dataclass(frozen=True, slots=True)
class Moved:
    """What ``from_id`` int32 (N,) held is in ``to_id`` (N,) now; several may have met in one.

    ``heaviest`` are the rows, at most one per voxel, that outweigh all others there.
    """

    from_id: Int32
    to_id: Int32
    heaviest: Int64

    def where(self, voxel_id: Int32, count: int) -> Int32:
        """Return where the surface of voxels (M,) is now, of ``count`` ids in all."""
        now_id = np.arange(count, dtype=np.int32)
        now_id[self.from_id] = self.to_id
        return now_id[voxel_id]


class Voxels:
    """Weighted sums per voxel; a voxel without weight is empty but keeps its id.

    Because only sums are kept, the order in which surfaces arrive does not matter. Ids are dense
    from 0 and belong to their coordinate for ever: there are as many as there is surface.
    """

    def __init__(self, voxel_size_m: float) -> None:
        self.voxel_size_m = voxel_size_m
        self.cells = Cells()
        self._count = 0
        self._place = np.zeros(0, np.int32)
        self._sums = np.zeros((0, _SUMS), np.float64)
        self.misses = np.zeros(0, np.uint8)
        self.anchor = np.zeros(0, np.int32)

    def __len__(self) -> int:
        """Return the number of ids given so far, empty voxels included."""
        return self._count

    def integrate(self, surface: SurfacePoints, anchor: int = 0) -> Touched:
        """Add every point of ``surface`` to its voxel; empty ones note ``anchor``, the keyframe.

        Raises:
            ValueError: a point more than ``COORD_LIMIT`` voxels from the origin along an axis.
        """
        known = len(self)
        id_of_point = self._enter(self._coord_of(surface.points_world))
        voxel_id = distinct(id_of_point, len(self))
        row = np.empty(len(self), np.int32)
        row[voxel_id] = np.arange(len(voxel_id), dtype=np.int32)
        of_point = row.take(id_of_point)
        sums = self._sums.take(voxel_id, axis=0)
        self.anchor[voxel_id[sums[:, _WEIGHT] == 0.0]] = anchor
        sums += _sums_of(surface, of_point, len(voxel_id))
        put_rows(self._sums, voxel_id, sums)
        self.misses[voxel_id] = 0
        return Touched(voxel_id, of_point, voxel_id[np.searchsorted(voxel_id, known) :])

    def clear(self, voxel_id: Int32) -> None:
        """Forget what these voxels hold: the space is free."""
        self._sums[voxel_id] = 0.0
        self.misses[voxel_id] = 0

    def move(self, from_id: Int32, motion: Float64) -> Moved:
        """Move what voxels hold by rigid motions (N, 4, 4), one each, into the voxels there.

        Raises:
            ValueError: a motion that leads out of the grid; nothing has moved then.
        """
        sums = self._sums.take(from_id, axis=0)
        weight, rotation = sums[:, _WEIGHT], motion[:, :3, :3]
        sums[:, _POSITION] = np.einsum("nij,nj->ni", rotation, sums[:, _POSITION])
        sums[:, _POSITION] += motion[:, :3, 3] * weight[:, None]
        sums[:, _NORMAL] = np.einsum("nij,nj->ni", rotation, sums[:, _NORMAL])
        coord = self._coord_of(sums[:, _POSITION] / weight[:, None])
        anchor = self.anchor.take(from_id)
        self.clear(from_id)
        to_id = self._enter(coord)
        stayed = self._weights(to_id)
        np.add.at(self._sums, to_id, sums)
        heaviest = first_of_each(np.lexsort((from_id, -weight)), to_id)
        heaviest = heaviest[weight[heaviest] > stayed[heaviest]]
        self.anchor[to_id[heaviest]] = anchor[heaviest]
        return Moved(from_id, to_id, heaviest)

    def occupied(self, voxel_id: Int32) -> Int32:
        """Return those of ``voxel_id`` that hold a surface."""
        return voxel_id.compress(self._weights(voxel_id) > 0.0)

    def coord(self, voxel_id: Int32) -> Int32:
        """Return int32 (M, 3) = floor(p / voxel_size)."""
        return self.cells.coord(self._place.take(voxel_id))

    def cell(self, voxel_id: Int32) -> Int32:
        """Return the cells int32 (M,) in which these voxels lie."""
        return self._place.take(voxel_id) >> SLOT_BITS

    def points_world(self, voxel_id: Int32) -> Float64:
        """Return mean positions float64 (M, 3), metres."""
        sums = self._sums.take(voxel_id, axis=0)
        return divided(sums[:, _POSITION], sums[:, _WEIGHT])

    def normals_world(self, voxel_id: Int32) -> Float64:
        """Return unit normals float64 (M, 3); zero where views from both sides cancel out."""
        return unit_rows(self._sums.take(voxel_id, axis=0)[:, _NORMAL])

    def rgb(self, voxel_id: Int32) -> UInt8:
        """Return mean colours uint8 (M, 3)."""
        return self.means(voxel_id)[1]

    def means(self, voxel_id: Int32) -> tuple[Float32, UInt8]:
        """Return ``points_world`` as float32 (M, 3) and ``rgb`` of voxels."""
        return _means(self._sums.take(voxel_id, axis=0))

    def means_and_normals(self, voxel_id: Int32) -> tuple[Float32, UInt8, Float64]:
        """Return ``means`` and ``normals_world`` of voxels."""
        sums = self._sums.take(voxel_id, axis=0)
        return *_means(sums), unit_rows(sums[:, _NORMAL])

    def features(self, voxel_id: Int32) -> tuple[Float64, Float32]:
        """Return ``normals_world`` and the mean colours float32 (M, 3) in 0..1 of voxels."""
        sums = self._sums.take(voxel_id, axis=0)
        colours = divided(sums[:, _COLOUR], sums[:, _WEIGHT] * 255.0)
        return unit_rows(sums[:, _NORMAL]), colours.astype(np.float32)

    def _weights(self, voxel_id: Int32) -> Float64:
        # Not a column of the table: to take from one copies all of it.
        return self._sums.reshape(-1).take(voxel_id * _SUMS + _WEIGHT)

    def _coord_of(self, points_world: Float64) -> Int32:
        coord = np.floor(points_world / self.voxel_size_m)
        if not (np.abs(coord) < COORD_LIMIT).all():
            raise ValueError(f"voxel coordinate outside +-{COORD_LIMIT}")
        return coord.astype(np.int32)

    def _enter(self, coord: Int32) -> Int32:
        """Return the ids of coordinates (N, 3); new ones get the next ids, in order of places."""
        place = self.cells.enter(coord)
        voxel_id = self.cells.occupants(place)
        missing = np.flatnonzero(voxel_id < 0)
        new_place, inverse = np.unique(place.take(missing), return_inverse=True)
        new_id = np.arange(len(self), len(self) + len(new_place), dtype=np.int32)
        voxel_id[missing] = new_id.take(inverse)
        self.cells.occupy(new_place, new_id)
        self._append(new_place)
        return voxel_id

    def _append(self, place: Int32) -> None:
        known, self._count = self._count, self._count + len(place)
        self._place = with_rows(self._place, len(self), 0)
        self._sums = with_rows(self._sums, len(self), 0.0)
        self.misses = with_rows(self.misses, len(self), 0)
        self.anchor = with_rows(self.anchor, len(self), 0)
        self._place[known : len(self)] = place


def _means(sums: Float64) -> tuple[Float32, UInt8]:
    weight = np.ascontiguousarray(sums[:, _WEIGHT])
    points, rgb = divided(sums[:, _POSITION], weight), divided(sums[:, _COLOUR], weight)
    return points.astype(np.float32), np.rint(rgb).astype(np.uint8)


def _sums_of(surface: SurfacePoints, of_point: Int32, count: int) -> Float64:
    """Return the sums (count, 10) of the points of each voxel."""
    columns: list[Array] = [*surface.points_world.T, *surface.normals_world.T, *surface.rgb.T]
    sums = np.empty((count, _SUMS), np.float64)
    sums[:, _WEIGHT] = np.bincount(of_point, surface.weight, count)
    for column, values in enumerate(columns, start=1):
        sums[:, column] = np.bincount(of_point, values * surface.weight, count)
    return sums
