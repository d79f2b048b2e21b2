"""Tables whose rows are ids: growing, marking and choosing rows."""

import numpy as np

from sceneq_core.arrays import Array, Bool, Int32, Int64


def with_rows(array: Array, count: int, fill: float) -> Array:
    """Return ``array`` with at least ``count`` rows; new rows hold ``fill``.

    The capacity doubles, so appending rows costs constant time on average.
    """
    if count <= len(array):
        return array
    capacity = max(count, 2 * len(array))
    grown = np.full((capacity, *array.shape[1:]), fill, array.dtype)
    grown[: len(array)] = array
    return grown


def marked(row_id: Int32, count: int) -> Bool:
    """Return bool (count,), true at ``row_id``."""
    mark = np.zeros(count, np.bool_)
    mark[row_id] = True
    return mark


def distinct(row_id: Int32, count: int) -> Int32:
    """Return the distinct ids of ``row_id``, sorted; all are in 0..count-1.

    For ids of a dense table this is far quicker than sorting or hashing them.
    """
    return np.flatnonzero(marked(row_id, count)).astype(np.int32)


def first_of_each(order: Int64, key: Array) -> Int64:
    """Return, per distinct key in sorted order, the row that comes first for it in ``order``."""
    return order[np.unique(key[order], return_index=True)[1]]
