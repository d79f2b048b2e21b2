"""Numbers of the segments that external masks are counted as."""

import numpy as np

from sceneq_core.arrays import Int32
from sceneq_core.mapping.coverage import Coverage

NO_MASK = -1
_BLOCK = 1024
"""Masks that share their views; segments of one view have to follow each other."""


class MaskSegments:
    """The segment of every external mask in each of the views that it is worth.

    The views have numbers below 0, which no keyframe has.
    """

    def __init__(self) -> None:
        self._first: dict[tuple[int, int], int] = {}

    def numbers(self, mask: Int32, view: int, coverage: Coverage) -> Int32:
        """Return the segments int32 (N,) of masks in a view, opened where they are new."""
        block, place = np.divmod(mask, _BLOCK)
        blocks, row = np.unique(block, return_inverse=True)
        first = [self._opened((number, view), coverage) for number in blocks.tolist()]
        return (np.array(first, np.int32)[row] + place).astype(np.int32)

    def all_numbers(self) -> Int32:
        """Return the numbers of all segments opened so far."""
        first = np.array([*self._first.values()], np.int32)
        return np.add.outer(first, np.arange(_BLOCK, dtype=np.int32)).reshape(-1).astype(np.int32)

    def renumber(self, number: Int32) -> None:
        """Give every segment the number that ``number`` holds in its place."""
        self._first = {key: int(number[first]) for key, first in self._first.items()}

    def _opened(self, key: tuple[int, int], coverage: Coverage) -> int:
        if key not in self._first:
            self._first[key] = coverage.open_segments(_BLOCK, -1 - len(self._first))
        return self._first[key]
