"""What is true of a scene, before an evaluation chooses its classes."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32, Int64
from sceneq_core.evaluation.annotation import Annotation
from sceneq_tools.evaluation.vocabulary import Names, Vocabulary

UNNAMED: Names = ()


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """N evaluation points and the things they belong to.

    Attributes:
        points_world: float32 (N, 3) metres, ``None`` when only their number is known: then
            predictions must be masks over the very same points.
        name: int64 (N,) place in ``names`` of what each point is called.
        number: int64 (N,) number of the thing in its scene, 0 = unannotated.
        names: what things are called; ``names[0]`` is ``()``.
        source: how these points came about, for people.
    """

    points_world: Float32 | None
    name: Int64
    number: Int64
    names: tuple[Names, ...]
    source: str

    def __len__(self) -> int:
        return len(self.number)

    def annotation(self, vocabulary: Vocabulary) -> Annotation:
        """Return labels in the numbers of ``vocabulary``; 0 = not in it."""
        return Annotation(vocabulary.numbers(self.names)[self.name], self.number)

    def not_in(self, vocabulary: Vocabulary) -> list[str]:
        """Return the usual names of the things here that are not in ``vocabulary``."""
        here = np.bincount(self.name, minlength=len(self.names)) > 0
        numbers = vocabulary.numbers(self.names)
        left = {
            n[0] for n, i, h in zip(self.names, numbers, here, strict=True) if n and h and not i
        }
        return sorted(left)


def truth_of_things(
    points_world: Float32 | None, number: Int64, named: dict[int, Names], source: str
) -> Truth:
    """Return the truth about points that know the ``number`` (N,) of their thing.

    Things that are not in ``named`` count as unannotated, as 0 does.
    """
    known = sorted(named)
    place_of = np.zeros(max([0, *known, int(number.max(initial=0))]) + 1, np.int64)
    place_of[known] = np.arange(1, len(known) + 1)
    name = place_of[number]
    names = (UNNAMED, *(named[one] for one in known))
    return Truth(points_world, name, np.where(name > 0, number, 0), names, source)
