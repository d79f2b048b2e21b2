"""A table whose rows are lists of numbers."""

import numpy as np

from sceneq_core.arrays import Int32, Int64
from sceneq_core.mapping.rows import with_rows

_LEAST = 4096


class Ragged:
    """Lists of int32 by row id, in one buffer, so that many lists are read at once.

    A list that is set again goes to the end of the buffer; when more than half of the buffer is
    what lists have left, it is packed. So it stays as small as its contents.
    """

    def __init__(self) -> None:
        self._numbers = np.zeros(_LEAST, np.int32)
        self._used = 0
        self._start = np.zeros(0, np.int64)
        self._length = np.zeros(0, np.int64)

    def put(self, row: Int32, length: Int64, numbers: Int32) -> None:
        """Let each of the distinct ``row`` hold the next ``length`` of ``numbers``."""
        count = int(row.max(initial=-1)) + 1
        self._start = with_rows(self._start, count, 0)
        self._length = with_rows(self._length, count, 0)
        self._numbers = with_rows(self._numbers, self._used + len(numbers), 0)
        self._numbers[self._used : self._used + len(numbers)] = numbers
        self._start[row] = self._used + np.cumsum(length) - length
        self._length[row] = length
        self._used += len(numbers)
        self._pack()

    def forget(self, row: Int32) -> None:
        """Empty these lists."""
        self._length[row] = 0

    def of(self, row: Int32) -> Int32:
        """Return the numbers of these lists, one list after the other."""
        length = self._length.take(row)
        before = np.cumsum(length) - length
        shift = np.repeat(self._start.take(row) - before, length)
        numbers: Int32 = self._numbers.take(np.arange(len(shift)) + shift)
        return numbers

    def _pack(self) -> None:
        if self._used < _LEAST or self._used < 2 * int(self._length.sum()):
            return
        row = np.flatnonzero(self._length).astype(np.int32)
        length, numbers = self._length[row], self.of(row)
        self._numbers = with_rows(numbers, _LEAST, 0)
        self._start[row], self._used = np.cumsum(length) - length, len(numbers)
