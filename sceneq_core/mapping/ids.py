"""Numbers for the rows of a table, so that the table stays as small as what is alive."""

import numpy as np

from sceneq_core.arrays import Int32


class Ids:
    """Hands out the smallest free numbers from 0; what is given back is handed out again."""

    def __init__(self) -> None:
        self._count = 0
        self._free: list[int] = []

    def __len__(self) -> int:
        """Return one more than the largest number handed out so far."""
        return self._count

    def take(self, count: int) -> Int32:
        """Return ``count`` numbers, int32, those given back first."""
        again = [self._free.pop() for _ in range(min(count, len(self._free)))]
        fresh = range(self._count, self._count + count - len(again))
        self._count += len(fresh)
        return np.array([*again, *fresh], np.int32)

    def give_back(self, number: Int32) -> None:
        """Take numbers back that are not used any more; more than once does no harm."""
        self._free = sorted({*self._free, *number.tolist()}, reverse=True)
