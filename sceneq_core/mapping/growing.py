"""Arrays that grow by doubling, so that appending rows costs constant time on average."""

import numpy as np

from sceneq_core.arrays import Array


def with_rows(array: Array, count: int, fill: float) -> Array:
    """Return ``array`` with at least ``count`` rows; new rows hold ``fill``."""
    if count <= len(array):
        return array
    capacity = max(count, 2 * len(array))
    grown = np.full((capacity, *array.shape[1:]), fill, array.dtype)
    grown[: len(array)] = array
    return grown
