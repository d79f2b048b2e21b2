"""Image vectors by instance id, in one matrix: one product compares them all with an example."""

from collections.abc import Iterable, Mapping

import numpy as np

from sceneq_core.arrays import Float32, Float64, Int64

_NONE = -1
UNKNOWN = -1.0
"""The cosine with what is not in the table."""


class ImageTable:
    """Vectors of length 1 by id, with their cosines to examples kept up to date."""

    def __init__(self) -> None:
        self._vectors: Float32 = np.zeros((0, 0), np.float32)
        self._slot_of_id: Int64 = np.zeros(0, np.int64)
        self._free: list[int] = []
        self._examples: dict[int, Float32] = {}
        self._cosine: dict[int, Float64] = {}

    def put(self, vectors: Mapping[int, Float32]) -> None:
        """Take over vectors (F,) by id; one of another length than the first is left out."""
        width = self._vectors.shape[1] or max((len(v) for v in vectors.values()), default=0)
        usable = {key: vector for key, vector in vectors.items() if vector.shape == (width,)}
        if not usable:
            return
        self._make_room(max(usable), len(usable), width)
        slots = np.array([self._slot(key) for key in usable], np.int64)
        self._vectors[slots] = list(usable.values())
        for number, example in self._examples.items():
            self._cosine[number][slots] = self._vectors[slots] @ example

    def remove(self, ids: Iterable[int]) -> None:
        """Forget vectors."""
        for key in ids:
            if key < len(self._slot_of_id) and self._slot_of_id[key] != _NONE:
                self._free.append(int(self._slot_of_id[key]))
                self._slot_of_id[key] = _NONE

    def cosines(self, number: int, example: Float32, ids: Int64) -> Float64:
        """Return the cosines (N,) of ``ids`` with an ``example`` (F,) of that number."""
        if example.shape != (self._vectors.shape[1],):
            return np.full(len(ids), UNKNOWN)
        if number not in self._cosine:
            self._examples[number] = example
            self._cosine[number] = (self._vectors @ example).astype(np.float64)
        inside = ids < len(self._slot_of_id)
        slots = np.where(inside, self._slot_of_id[np.where(inside, ids, 0)], _NONE)
        found: Float64 = np.where(slots == _NONE, UNKNOWN, self._cosine[number][slots])
        return found

    def keep_examples(self, numbers: Iterable[int]) -> None:
        """Compare with these only."""
        kept = set(numbers)
        for number in [one for one in self._examples if one not in kept]:
            del self._examples[number], self._cosine[number]

    def _slot(self, key: int) -> int:
        if self._slot_of_id[key] == _NONE:
            self._slot_of_id[key] = self._free.pop()
        return int(self._slot_of_id[key])

    def _make_room(self, highest_id: int, count: int, width: int) -> None:
        """Grow by half at least, so that growing stays cheap."""
        short = highest_id + 1 - len(self._slot_of_id)
        if short > 0:
            more = max(short, len(self._slot_of_id) // 2)
            self._slot_of_id = np.append(self._slot_of_id, np.full(more, _NONE, np.int64))
        have = len(self._vectors)
        if count > len(self._free):
            more = max(count, have // 2)
            space = np.zeros((more, width), np.float32)
            self._vectors = np.concatenate([self._vectors.reshape(have, width), space])
            self._free.extend(range(have + more - 1, have - 1, -1))
            self._cosine = {
                number: np.append(known, np.zeros(more)) for number, known in self._cosine.items()
            }
