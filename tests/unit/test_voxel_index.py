"""Voxel ids by coordinate."""

import numpy as np
import pytest

from sceneq_core.mapping.voxel_index import COORD_LIMIT, VoxelIndex, pack_coord, unpack_coord


def coords(*rows):
    return np.array(rows, np.int32).reshape(-1, 3)


def test_new_coordinates_get_dense_ids_in_sorted_order_and_keep_them():
    index = VoxelIndex()
    assert index.insert(coords((5, 0, 0), (-1, 2, 3), (5, 0, 0))).tolist() == [1, 0, 1]
    assert index.insert(coords((0, 0, 0), (5, 0, 0))).tolist() == [2, 1]
    assert len(index) == 3


def test_lookup_returns_minus_one_for_the_unknown():
    index = VoxelIndex()
    assert index.lookup(coords((1, 2, 3))).tolist() == [-1]
    index.insert(coords((1, 2, 3)))
    assert index.lookup(coords((1, 2, 3), (3, 2, 1))).tolist() == [0, -1]


def test_growing_beyond_the_first_table_loses_nothing():
    index = VoxelIndex()
    grid = np.stack(np.meshgrid(*[np.arange(-22, 22)] * 3, indexing="ij"), axis=-1)
    coord = grid.reshape(-1, 3).astype(np.int32)
    for start in range(0, len(coord), 10_000):
        index.insert(coord[start : start + 10_000])
    assert len(index) == 44**3
    assert np.array_equal(index.lookup(coord), np.arange(44**3))
    assert (index.lookup(coord + 100) == -1).all()


def test_empty_input_gives_empty_output():
    index = VoxelIndex()
    assert index.insert(coords()).shape == (0,)
    assert index.lookup(coords()).dtype == np.int32


def test_packing_round_trips_to_the_limits_and_refuses_more():
    edge = coords((-COORD_LIMIT, 0, COORD_LIMIT - 1), (1, -2, 3))
    assert np.array_equal(unpack_coord(pack_coord(edge)), edge)
    with pytest.raises(ValueError, match="voxel coordinate outside"):
        pack_coord(coords((COORD_LIMIT, 0, 0)))
