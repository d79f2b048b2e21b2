"""Which voxel has which id: an open-addressing hash table in numpy arrays."""

import numpy as np

from sceneq_core.arrays import Int32, Int64

COORD_LIMIT = 1 << 20
"""Coordinates are in [-COORD_LIMIT, COORD_LIMIT): 21 km either way with 2 cm voxels."""

_EMPTY = np.int64(-1)
_MULTIPLIER = np.uint64(0x9E3779B97F4A7C15)
_FIRST_BITS = 16


def pack_coord(coord: Int32) -> Int64:
    """Return one non-negative int64 key per row of ``coord`` int32 (N, 3); keys order as x, y, z.

    Raises:
        ValueError: a coordinate outside ``COORD_LIMIT``.
    """
    shifted = coord.astype(np.int64) + COORD_LIMIT
    if shifted.size and (shifted.min() < 0 or shifted.max() >= 2 * COORD_LIMIT):
        raise ValueError(f"voxel coordinate outside +-{COORD_LIMIT}")
    key: Int64 = (shifted[:, 0] << 42) | (shifted[:, 1] << 21) | shifted[:, 2]
    return key


def unpack_coord(key: Int64) -> Int32:
    """Return the int32 (N, 3) coordinates of packed keys."""
    mask = (1 << 21) - 1
    coord = np.stack((key >> 42, (key >> 21) & mask, key & mask), axis=1)
    return (coord - COORD_LIMIT).astype(np.int32)


class VoxelIndex:
    """Voxel coordinates to dense ids from 0; an id belongs to its coordinate for ever."""

    def __init__(self) -> None:
        self._count = 0
        self._allocate(_FIRST_BITS)

    def __len__(self) -> int:
        return self._count

    def lookup(self, coord: Int32) -> Int32:
        """Return the int32 (N,) ids of ``coord`` int32 (N, 3), -1 where there is none."""
        return self._find(pack_coord(coord))

    def insert(self, coord: Int32) -> Int32:
        """Return the ids of ``coord``, giving new coordinates the next ids in sorted order."""
        key = pack_coord(coord)
        voxel_id = self._find(key)
        missing = voxel_id < 0
        if missing.any():
            new_key, inverse = np.unique(key[missing], return_inverse=True)
            voxel_id[missing] = self._append(new_key)[inverse]
        return voxel_id

    def extend(self, coord: Int32) -> None:
        """Give new coordinates (N, 3), all different, the next ids in their own order."""
        self._append(pack_coord(coord))

    def coords(self, first: int) -> Int32:
        """Return the coordinates (N, 3) of all ids from ``first`` on, in the order of ids."""
        wanted = np.flatnonzero((self._key != _EMPTY) & (self._id >= first))
        in_order = wanted[np.argsort(self._id[wanted])]
        return unpack_coord(self._key[in_order])

    def _append(self, new_key: Int64) -> Int32:
        new_id = np.arange(self._count, self._count + len(new_key), dtype=np.int32)
        self._count += len(new_key)
        if 2 * self._count > len(self._key):
            self._grow()
        self._store(new_key, new_id)
        return new_id

    def _allocate(self, bits: int) -> None:
        self._bits = bits
        self._key = np.full(1 << bits, _EMPTY)
        self._id = np.full(1 << bits, -1, np.int32)

    def _grow(self) -> None:
        used = self._key != _EMPTY
        key, voxel_id = self._key[used], self._id[used]
        self._allocate(int(2 * self._count - 1).bit_length() + 1)
        self._store(key, voxel_id)

    def _slot(self, key: Int64) -> Int64:
        hashed = key.view(np.uint64) * _MULTIPLIER
        return (hashed >> np.uint64(64 - self._bits)).astype(np.int64)

    def _find(self, key: Int64) -> Int32:
        """Probe all keys at once; every round follows only the keys that collided."""
        found = np.full(len(key), -1, np.int32)
        slot, pending = self._slot(key), np.arange(len(key))
        while len(pending):
            held = self._key.take(slot)
            is_hit = held == key.take(pending)
            hit = np.flatnonzero(is_hit)
            found[pending.take(hit)] = self._id.take(slot.take(hit))
            going_on = np.flatnonzero(~is_hit & (held != _EMPTY))
            pending = pending.take(going_on)
            slot = (slot.take(going_on) + 1) & (len(self._key) - 1)
        return found

    def _store(self, key: Int64, voxel_id: Int32) -> None:
        """Place distinct new keys; of those that meet in an empty slot one stays per round."""
        slot = self._slot(key)
        while len(key):
            empty = self._key[slot] == _EMPTY
            self._key[slot[empty]] = key[empty]
            placed = self._key[slot] == key
            self._id[slot[placed]] = voxel_id[placed]
            key, voxel_id = key[~placed], voxel_id[~placed]
            slot = (slot[~placed] + 1) & (len(self._key) - 1)
