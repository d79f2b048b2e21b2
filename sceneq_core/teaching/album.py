"""What the instances of a map look like to one encoder, and who looks like what was taught."""

from collections.abc import Iterable, Mapping

from sceneq_core.arrays import Float32, Float64, Int64
from sceneq_core.teaching.evidence import Judgement
from sceneq_core.teaching.image_table import ImageTable
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
        self._images = ImageTable()

    def put(
        self, map_epoch: int, looks: Mapping[int, tuple[Float32, Float32]], removed: Iterable[int]
    ) -> None:
        """Take over changed descriptors and features by id in the map of ``map_epoch``."""
        if map_epoch != self._map_epoch:
            self._looks, self._images = {}, ImageTable()
        self._map_epoch = map_epoch
        gone = tuple(removed)
        for key in gone:
            self._looks.pop(key, None)
        self._images.remove(gone)
        changed = {key: Looks(self.model_id, *vectors) for key, vectors in looks.items()}
        self._looks.update(changed)
        self._images.put({key: one.image for key, one in changed.items()})

    def looks_of(self, instance_id: int) -> Looks | None:
        """Return what an instance looks like, if that is known."""
        return self._looks.get(instance_id)

    def cosines(self, taught: Taught, ids: Int64) -> Float64 | None:
        """Return the cosines (N,) of what was taught with instances; -1 where one is unknown.

        ``None`` when it was taught to another encoder: vectors of two are never compared.
        """
        if taught.looks.model_id != self.model_id or not len(taught.looks.descriptor):
            return None
        return self._images.cosines(taught.number, taught.looks.image, ids)

    def compare_with(self, taught: Iterable[Taught]) -> None:
        """Compare with nothing else."""
        self._images.keep_examples(one.number for one in taught)
