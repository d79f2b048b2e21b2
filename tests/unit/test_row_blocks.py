"""A matrix in blocks is the matrix."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.routing.row_blocks import RowBlocks

WIDTH = 3


def blocks_of(sizes: list[int]) -> list[np.ndarray]:
    rng = np.random.default_rng(sum(sizes))
    return [rng.normal(size=(size, WIDTH)).astype(np.float32) for size in sizes]


@given(st.lists(st.integers(0, 5), max_size=6))
def test_products_and_rows_are_those_of_the_whole(sizes: list[int]) -> None:
    parts = blocks_of(sizes)
    whole = np.concatenate([np.zeros((0, WIDTH), np.float32), *parts])
    blocks = RowBlocks(parts, WIDTH)
    vector, matrix = np.array([1, -2, 3], np.float32), np.eye(WIDTH, 2, dtype=np.float32)
    assert (len(blocks), blocks.shape) == (len(whole), whole.shape)
    assert np.array_equal(np.asarray(blocks), whole)
    assert [row.tolist() for row in blocks] == whole.tolist()
    np.testing.assert_allclose(blocks @ vector, whole @ vector, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(blocks @ matrix, whole @ matrix, rtol=1e-5, atol=1e-6)
    backwards = np.arange(len(whole))[::-1]
    assert np.array_equal(blocks[backwards], whole[backwards])
    for row in range(len(whole)):
        assert np.array_equal(blocks[row], whole[row])


@pytest.mark.parametrize("row", [-1, 5, 6])
def test_a_row_that_is_not_there_is_refused(row: int) -> None:
    blocks = RowBlocks(blocks_of([2, 0, 3, 0]), WIDTH)
    with pytest.raises(IndexError, match=str(row)):
        blocks[row]
    with pytest.raises(IndexError, match="of 5"):
        blocks[np.array([0, row])]


def test_no_rows_are_still_a_matrix() -> None:
    blocks = RowBlocks([], WIDTH)
    assert (blocks @ np.zeros(WIDTH, np.float32)).shape == (0,)
    assert (blocks @ np.zeros((WIDTH, 2), np.float32)).shape == (0, 2)
    assert blocks[np.zeros(0, np.int64)].shape == (0, WIDTH)
    assert np.asarray(blocks, np.float64).dtype == np.float64
