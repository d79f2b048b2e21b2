"""Sums under sparse keys."""

import numpy as np

from sceneq_core.arrays import Bool, Int64
from sceneq_core.mapping.rows import first_of_runs


class Tally:
    """Sums under int64 keys; a key whose sum is 0 is not kept.

    Attributes:
        key: int64 (N,) sorted.
        total: int64 (N,) the sum under each key.
    """

    def __init__(self) -> None:
        self.key = np.zeros(0, np.int64)
        self.total = np.zeros(0, np.int64)

    def add(self, key: Int64, amount: Int64) -> None:
        """Add amounts, which may be negative; a key may occur more than once."""
        order = np.argsort(key)
        key, amount = key.take(order), amount.take(order)
        start = first_of_runs(key)
        if len(start):
            self._add_distinct(key.take(start), np.add.reduceat(amount, start))

    def under(self, prefix: Int64, bits: int) -> Int64:
        """Return the rows, sorted, of the keys that are one of ``prefix``, sorted, above ``bits``.

        Of a few prefixes that is far quicker than to look at every key.
        """
        start, end = (np.searchsorted(self.key, (prefix + i) << bits) for i in (0, 1))
        length = end - start
        return np.arange(length.sum()) + np.repeat(end - np.cumsum(length), length)

    def drop_pairs(self, prefix: Int64, bits: int) -> None:
        """Forget what is under one of ``prefix``, sorted: pairs that are here both ways round."""
        row = self.under(prefix, bits)
        pair = self.key.take(row)
        turned = (pair & ((1 << bits) - 1)) << bits | pair >> bits
        gone = np.concatenate((row, np.searchsorted(self.key, turned)))
        if len(gone):
            self.key, self.total = np.delete(self.key, gone), np.delete(self.total, gone)

    def _add_distinct(self, key: Int64, amount: Int64) -> None:
        key, amount = key.compress(amount != 0), amount.compress(amount != 0)
        known, row = self._find(key)
        self.total[row] += amount.compress(known)
        gone = row.compress(self.total.take(row) == 0)
        if len(gone):
            self.key, self.total = np.delete(self.key, gone), np.delete(self.total, gone)
        if len(row) < len(key):
            key, amount = key.compress(~known), amount.compress(~known)
            place = np.searchsorted(self.key, key)
            self.key = np.insert(self.key, place, key)
            self.total = np.insert(self.total, place, amount)

    def _find(self, key: Int64) -> tuple[Bool, Int64]:
        """Return which keys (K,) are here, and the rows of those."""
        place = np.searchsorted(self.key, key)
        known = np.zeros(len(key), np.bool_)
        inside = np.flatnonzero(place < len(self.key))
        known[inside] = self.key.take(place.take(inside)) == key.take(inside)
        return known, place.compress(known)
