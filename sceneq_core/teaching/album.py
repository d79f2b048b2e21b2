"""What the instances of a map look like to one encoder, and who looks like what was taught."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from sceneq_core.arrays import Float32, Float64
from sceneq_core.teaching.evidence import Judgement
from sceneq_core.teaching.taught import Looks, Taught


class Album:
    """Keeps the looks of every instance, and the cosines with what was taught up to date.

    Cosines are worked out when something changes, not for every question.
    """

    def __init__(self, model_id: str, judgement: Judgement) -> None:
        self.model_id = model_id
        self.judgement = judgement
        self._map_epoch = 0
        self._looks: dict[int, Looks] = {}
        self._cosine: dict[int, dict[int, float]] = {}

    def put(
        self, map_epoch: int, looks: Mapping[int, tuple[Float32, Float32]], removed: Iterable[int]
    ) -> None:
        """Take over changed descriptors and features by id in the map of ``map_epoch``."""
        if map_epoch != self._map_epoch:
            self._looks, self._cosine = {}, {}
        self._map_epoch = map_epoch
        changed = {key: Looks(self.model_id, *vectors) for key, vectors in looks.items()}
        self._looks.update(changed)
        for gone in removed:
            self._looks.pop(gone, None)
        for known in self._cosine.values():
            for key in (*removed, *changed):
                known.pop(key, None)

    def looks_of(self, instance_id: int) -> Looks | None:
        """Return what an instance looks like, if that is known."""
        return self._looks.get(instance_id)

    def cosines(self, taught: Taught, instance_id: Sequence[int]) -> Float64 | None:
        """Return the cosines of what was taught with instances; -1 where an instance is unknown.

        ``None`` when it was taught to another encoder: vectors of two are never compared.
        """
        if taught.looks.model_id != self.model_id or not len(taught.looks.descriptor):
            return None
        known = self._cosine.setdefault(taught.number, {})
        exemplar = taught.looks.image
        for key in instance_id:
            if key not in known and key in self._looks:
                known[key] = _cosine(self._looks[key].image, exemplar)
        return np.array([known.get(key, -1.0) for key in instance_id])

    def compare_with(self, taught: Iterable[Taught]) -> None:
        """Forget the cosines with everything else."""
        kept = {one.number for one in taught}
        self._cosine = {number: known for number, known in self._cosine.items() if number in kept}


def _cosine(one: Float32, other: Float32) -> float:
    return float(one @ other) if one.shape == other.shape else -1.0
