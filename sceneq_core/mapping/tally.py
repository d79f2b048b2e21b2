"""Sums under sparse keys."""

import numpy as np

from sceneq_core.arrays import Bool, Int64


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
        order = np.argsort(key, kind="stable")
        key, amount = key[order], amount[order]
        start = np.flatnonzero(np.append(True, key[1:] != key[:-1])[: len(key)])
        if len(start):
            self._add_distinct(key[start], np.add.reduceat(amount, start))

    def under(self, prefix: Int64, bits: int) -> Int64:
        """Return the rows, sorted, of the keys that are one of ``prefix``, sorted, above ``bits``.

        Of a few prefixes that is far quicker than to look at every key.
        """
        start, end = (np.searchsorted(self.key, (prefix + i) << bits) for i in (0, 1))
        length = end - start
        return np.arange(length.sum()) + np.repeat(end - np.cumsum(length), length)

    def drop(self, row: Bool) -> None:
        """Forget the keys in marked rows (N,)."""
        self.key, self.total = self.key[~row], self.total[~row]

    def _add_distinct(self, key: Int64, amount: Int64) -> None:
        place = np.searchsorted(self.key, key)
        known = np.append(self.key, -1)[place] == key
        self.total[place[known]] += amount[known]
        new = ~known
        self.key = np.insert(self.key, place[new], key[new])
        self.total = np.insert(self.total, place[new], amount[new])
        kept = self.total != 0
        if not kept.all():
            self.key, self.total = self.key[kept], self.total[kept]
