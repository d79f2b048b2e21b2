"""The numbers that labels have in an evaluation."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Int64
from sceneq_core.evaluation.scannet200_ids import INSTANCE_CLASSES, NOT_INSTANCES, SPLITS

Names = tuple[str, ...]
"""What something is called, the usual name first; ``()`` = it has no name."""


@dataclass(frozen=True, slots=True, eq=False)
class Vocabulary:
    """The classes of an evaluation: number (from 1) -> name, and named groups of names."""

    name: str
    classes: Mapping[int, str]
    splits: Mapping[str, frozenset[str]]

    def numbers(self, named: Sequence[Names]) -> Int64:
        """Return the class number of each of the K things (K,): its first name that is a class.

        0 = none of its names is. Capitals do not matter.
        """
        number_of = {name.lower(): number for number, name in self.classes.items()}
        return np.array([_first(names, number_of) for names in named], np.int64)


SCANNET200 = Vocabulary("scannet200", INSTANCE_CLASSES, SPLITS)


def own_vocabulary(named: Iterable[Names]) -> Vocabulary:
    """Return the vocabulary of a truth itself: all the usual names in it, in alphabetical order.

    Wall and floor are left out, as they are in ScanNet200.
    """
    usual = sorted({names[0] for names in named if names} - NOT_INSTANCES)
    return Vocabulary("own", dict(enumerate(usual, 1)), {})


def _first(names: Names, number_of: Mapping[str, int]) -> int:
    return next((number_of[n.lower()] for n in names if n.lower() in number_of), 0)
