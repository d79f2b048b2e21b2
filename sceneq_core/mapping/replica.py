"""A reader's copy of the map, kept up to date by deltas."""

import numpy as np

from sceneq_core.arrays import Bool, Float32, Int32, UInt8
from sceneq_core.mapping.delta import MAX_INSTANCES, REMOVED, STATES, TENTATIVE, Instance, MapDelta
from sceneq_core.mapping.rows import with_rows
from sceneq_core.mapping.voxel_index import COORD_LIMIT

MAX_VOXELS = 1 << 26
SPARE_IDS, SPARSE = 1 << 22, 64
"""Columns are as long as the highest id. Of a map that lost most of its voxels few are told, but a
message of a few bytes is not to claim gigabytes: so many ids in all, or that many for every voxel.
"""
NO_SUPERPOINT = -1


class MapReplica:
    """The map as its deltas tell it: voxel columns indexed by voxel id, instances by id.

    Attributes:
        instances: every instance that is not removed, by id; the tentative own no voxels.
        frame_seq: the newest frame in the map, -1 before the first.
        stamp_ns: capture time of that frame, nanoseconds.
    """

    def __init__(self) -> None:
        self._clear()

    def apply(self, delta: MapDelta) -> None:
        """Take over ``delta``; one with ``full`` replaces everything.

        Raises:
            ValueError: columns of different length, ids or coordinates out of range; the replica
                is unchanged then.
        """
        _check(delta, 0 if delta.full else self.voxel_count)
        if delta.full:
            self._clear()
        self._write_voxels(delta)
        self._alive[delta.removed_voxel_id] = False
        for instance in delta.instances:
            self._write_instance(instance)
        self.frame_seq, self.stamp_ns = delta.frame_seq, delta.stamp_ns

    @property
    def voxel_count(self) -> int:
        """Number of voxel ids in use so far, dead ones included."""
        return self._count

    @property
    def voxel_coord(self) -> Int32:
        """Grid coordinates, int32 (N, 3), by voxel id."""
        return self._voxel_coord[: self._count]

    @property
    def points_world(self) -> Float32:
        """Mean positions in metres, float32 (N, 3), by voxel id."""
        return self._points_world[: self._count]

    @property
    def rgb(self) -> UInt8:
        """Mean colours, uint8 (N, 3), by voxel id."""
        return self._rgb[: self._count]

    @property
    def superpoint_id(self) -> Int32:
        """Superpoint of each voxel, int32 (N,), -1 = none."""
        return self._superpoint_id[: self._count]

    @property
    def alive(self) -> Bool:
        """Whether each voxel id is still part of the map, bool (N,)."""
        return self._alive[: self._count]

    def instance_of_voxel(self) -> Int32:
        """Return the instance of each voxel id, int32 (N,), 0 = none or dead."""
        return _lookup(self._instance_of_superpoint, self.superpoint_id) * self.alive

    def cloud(self) -> tuple[Float32, UInt8, Int32]:
        """Return points_world (M, 3), rgb (M, 3), instance_id (M,) of the living voxels.

        Sorted by voxel coordinate, so that equal maps give equal bytes.
        """
        living = np.flatnonzero(self.alive)
        x, y, z = self.voxel_coord[living].T
        order = living[np.lexsort((z, y, x))]
        return self.points_world[order], self.rgb[order], self.instance_of_voxel()[order]

    def _clear(self) -> None:
        self._count = 0
        self._voxel_coord = np.zeros((0, 3), np.int32)
        self._points_world = np.zeros((0, 3), np.float32)
        self._rgb = np.zeros((0, 3), np.uint8)
        self._superpoint_id = np.zeros(0, np.int32)
        self._alive = np.zeros(0, np.bool_)
        self._instance_of_superpoint = np.zeros(0, np.int32)
        self.instances: dict[int, Instance] = {}
        self.frame_seq, self.stamp_ns = -1, 0
        self.voxel_size_m = 0.0
        self.up_world = np.zeros(3)

    def _write_voxels(self, delta: MapDelta) -> None:
        self.voxel_size_m, self.up_world = delta.voxel_size_m, delta.up_world
        ids = delta.voxel_id
        if not len(ids):
            return
        self._reserve(int(ids.max()) + 1)
        self._voxel_coord[ids] = delta.voxel_coord
        self._points_world[ids] = delta.points_world
        self._rgb[ids] = delta.rgb
        self._superpoint_id[ids] = delta.superpoint_id
        self._alive[ids] = True

    def _reserve(self, count: int) -> None:
        self._count = max(self._count, count)
        self._voxel_coord = with_rows(self._voxel_coord, count, 0)
        self._points_world = with_rows(self._points_world, count, 0)
        self._rgb = with_rows(self._rgb, count, 0)
        self._superpoint_id = with_rows(self._superpoint_id, count, NO_SUPERPOINT)
        self._alive = with_rows(self._alive, count, False)

    def _write_instance(self, instance: Instance) -> None:
        owned = self._instance_of_superpoint
        owned[owned == instance.instance_id] = 0
        self.instances.pop(instance.instance_id, None)
        if instance.state == REMOVED:
            return
        self.instances[instance.instance_id] = instance
        if instance.state == TENTATIVE:
            return
        owned = with_rows(owned, int(instance.superpoint_id.max(initial=-1)) + 1, 0)
        owned[instance.superpoint_id] = instance.instance_id
        self._instance_of_superpoint = owned


def _lookup(instance_of_superpoint: Int32, superpoint_id: Int32) -> Int32:
    """Return the instance of each superpoint id, int32 of the same shape, 0 = none.

    Ids of -1 and ids that no instance ever named have no instance.
    """
    none = np.zeros(1, np.int32)
    table = np.concatenate((none, instance_of_superpoint, none))
    found: Int32 = table.take(superpoint_id + 1, mode="clip")
    return found


_COLUMNS = ("voxel_id", "voxel_coord", "points_world", "rgb", "superpoint_id")


def _check(delta: MapDelta, known_voxels: int) -> None:
    """Raise ``ValueError`` unless the columns of ``delta`` agree and its ids are in range."""
    rows = {name: len(getattr(delta, name)) for name in _COLUMNS}
    if len(set(rows.values())) > 1:
        raise ValueError(f"map delta: columns of different length: {rows}")
    if not 0 < delta.voxel_size_m < np.inf:
        raise ValueError(f"map delta: voxel_size_m {delta.voxel_size_m} is not positive")
    if not (np.isfinite(delta.points_world).all() and np.isfinite(delta.up_world).all()):
        raise ValueError("map delta: points_world or up_world is not finite")
    room = min(MAX_VOXELS, SPARE_IDS + SPARSE * (known_voxels + rows["voxel_id"]))
    _check_ids("voxel_id", delta.voxel_id, 0, room)
    _check_ids("voxel_coord", delta.voxel_coord, -COORD_LIMIT, COORD_LIMIT)
    _check_ids("superpoint_id", delta.superpoint_id, NO_SUPERPOINT, room)
    voxels = max(known_voxels, int(delta.voxel_id.max(initial=-1)) + 1)
    _check_ids("removed_voxel_id", delta.removed_voxel_id, 0, voxels)
    if len(delta.moved_from_id) != len(delta.moved_to_id):
        raise ValueError("map delta: moved_from_id and moved_to_id differ in length")
    _check_ids("moved_from_id", delta.moved_from_id, 0, MAX_VOXELS)
    _check_ids("moved_to_id", delta.moved_to_id, 0, MAX_VOXELS)
    for instance in delta.instances:
        if not 0 < instance.instance_id < MAX_INSTANCES or instance.state not in STATES:
            raise ValueError(f"map delta: instance {instance.instance_id} is {instance.state!r}")
        _check_ids("instance.superpoint_id", instance.superpoint_id, 0, room)


def _check_ids(field: str, ids: Int32, low: int, high: int) -> None:
    if len(ids) and not (low <= int(ids.min()) and int(ids.max()) < high):
        raise ValueError(f"map delta: {field} {ids.min()}..{ids.max()} outside {low}..{high - 1}")
