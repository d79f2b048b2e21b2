"""A tall matrix in blocks of rows: what changes is copied block by block, never as a whole."""

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from sceneq_core.arrays import Float32, Int64


class RowBlocks:
    """A matrix float32 (N, D) made of blocks (n, D) that are never written to again.

    It stands for a matrix wherever questions need one: ``@``, rows by index, ``np.asarray``.
    """

    __slots__ = ("_blocks", "_starts", "shape")

    def __init__(self, blocks: Sequence[Float32], width: int) -> None:
        counts = np.array([len(block) for block in blocks], np.int64)
        self._blocks = tuple(blocks)
        self._starts = np.cumsum(counts) - counts
        self.shape = (int(counts.sum()), width)

    def __len__(self) -> int:
        return self.shape[0]

    def __iter__(self) -> Iterator[Float32]:
        return (row for block in self._blocks for row in block)

    def __matmul__(self, other: Float32) -> Float32:
        """Return the product (N, ...) with ``other`` (D, ...)."""
        if not self._blocks:
            return np.zeros((0, *other.shape[1:]), np.float32)
        return np.concatenate([block @ other for block in self._blocks])

    def __getitem__(self, rows: int | Int64) -> Float32:
        """Return one row (D,), or some (M, D) in the order asked for; no negative numbers.

        Raises:
            IndexError: there are not so many rows.
        """
        if isinstance(rows, int):
            row: Float32 = self[np.array([rows], np.int64)][0]
            return row
        if len(rows) and not 0 <= rows.min() <= rows.max() < len(self):
            raise IndexError(f"rows {rows.min()} to {rows.max()} of {len(self)}")
        number = np.searchsorted(self._starts, rows, side="right") - 1
        places = zip(number.tolist(), (rows - self._starts[number]).tolist(), strict=True)
        chosen = [self._blocks[block][row] for block, row in places]
        return np.stack(chosen) if chosen else np.zeros((0, self.shape[1]), np.float32)

    def __array__(
        self, dtype: npt.DTypeLike | None = None, copy: bool | None = None
    ) -> npt.NDArray[np.generic]:
        """Return everything as one array: a copy, however it is asked for."""
        whole = np.concatenate([np.zeros((0, self.shape[1]), np.float32), *self._blocks])
        return whole.astype(dtype or np.float32, copy=False)
