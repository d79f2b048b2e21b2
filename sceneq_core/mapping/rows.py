"""Tables whose rows are ids: growing, marking and choosing rows."""

import numpy as np

from sceneq_core.arrays import Array, Bool, Int32, Int64


def with_rows(array: Array, count: int, fill: float) -> Array:
    """Return ``array`` with at least ``count`` rows; new rows hold ``fill``.

    The capacity doubles, so appending rows costs constant time on average.
    """
    if count <= len(array):
        return array
    shape = (max(count, 2 * len(array)), *array.shape[1:])
    # Zeroed memory is not resident until it is written: a table of zeros costs what it holds.
    grown = np.full(shape, fill, array.dtype) if fill else np.zeros(shape, array.dtype)
    grown[: len(array)] = array
    return grown


def put_rows(table: Array, row_id: Int32, rows: Array) -> None:
    """Set ``table[row_id] = rows``, both contiguous: each row as one item is thrice as quick."""
    item = np.dtype((np.void, table.itemsize * table.shape[1]))
    np.put(table.view(item).reshape(-1), row_id, rows.view(item).reshape(-1))


def marked(row_id: Array, count: int) -> Bool:
    """Return bool (count,), true at ``row_id``."""
    mark = np.zeros(count, np.bool_)
    mark[row_id] = True
    return mark


def distinct(row_id: Array, count: int) -> Int32:
    """Return the distinct ids of ``row_id``, sorted; all are in 0..count-1.

    For ids of a dense table this is far quicker than sorting or hashing them.
    """
    return np.flatnonzero(marked(row_id, count)).astype(np.int32)


def sorted_keys(*keys: Array) -> Array:
    """Return the distinct numbers of all ``keys``, sorted: what ``np.unique`` does by a hash."""
    key = np.sort(np.concatenate(keys) if len(keys) > 1 else keys[0])
    return key.take(first_of_runs(key))


def stable_order(row_id: Int32) -> Int64:
    """Return the rows sorted by their ids, all of them 0 or more, equal ones as they came.

    By halves of the ids: numbers of 16 bits are sorted by radix, ten times quicker.
    """
    order = np.argsort(row_id.astype(np.uint16), kind="stable")
    if row_id.max(initial=0) >= 1 << 16:
        high = (row_id >> 16).astype(np.uint16)
        order = order.take(np.argsort(high.take(order), kind="stable"))
    return order


def first_of_runs(sorted_key: Array) -> Int64:
    """Return the row with which each run of equal keys begins."""
    starts = np.ones(len(sorted_key), np.bool_)
    starts[1:] = sorted_key[1:] != sorted_key[:-1]
    return np.flatnonzero(starts)


def largest_of_runs(sorted_key: Array, size: Array) -> Int64:
    """Return per run of equal keys the row of the largest size, the first one among equals."""
    start = first_of_runs(sorted_key)
    if not len(start):
        return start
    length = np.diff(start, append=len(sorted_key))
    row = np.flatnonzero(size == np.repeat(np.maximum.reduceat(size, start), length))
    return row.take(first_of_runs(sorted_key.take(row)))


def runs(rows: Array) -> tuple[Int64, Int64]:
    """Return the rows of (N, K) that differ from the one before, and which each row repeats."""
    starts = np.ones(len(rows), np.bool_)
    if len(rows):
        changed = [column[1:] != column[:-1] for column in rows.T]
        starts[1:] = np.logical_or.reduce(changed)
    return np.flatnonzero(starts), np.cumsum(starts) - 1


def counted(key: Int64) -> tuple[Int64, Int64]:
    """Return the distinct keys, sorted, and how often each occurs.

    Rows of images and of cells mostly repeat the key before: runs are sorted, not keys.
    """
    first, _ = runs(key[:, None])
    value, row = np.unique(key.take(first), return_inverse=True)
    count = np.bincount(row, np.diff(first, append=len(key)), len(value))
    return value, count.astype(np.int64)


def first_of_each(order: Int64, key: Array) -> Int64:
    """Return, per distinct key in sorted order, the row that comes first for it in ``order``."""
    return order[np.unique(key[order], return_index=True)[1]]
