"""What is true of every evaluation point of one scene."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Int64

CODE_BASE = 1000
"""ScanNet writes label and instance of a point as one number: label * 1000 + instance."""


@dataclass(frozen=True, slots=True, eq=False)
class Annotation:
    """The annotated label and instance of N points.

    Attributes:
        label: int64 (N,) class number, 0 = none or one outside of the benchmark.
        number: int64 (N,) number of the instance in its scene, 0 = unannotated.

    Raises:
        ValueError: the two differ in length, or a value is negative.
    """

    label: Int64
    number: Int64

    def __post_init__(self) -> None:
        if self.label.ndim != 1 or self.label.shape != self.number.shape:
            shapes = f"{self.label.shape} and {self.number.shape}"
            raise ValueError(f"label, number: expected (N,) and (N,), got {shapes}")
        if len(self.label) and min(self.label.min(), self.number.min()) < 0:
            raise ValueError("label, number: negative")

    def __len__(self) -> int:
        return len(self.label)


def from_codes(code: Int64) -> Annotation:
    """Return what ScanNet's codes (N,), label * 1000 + instance, say; codes below 0 are none."""
    known = np.maximum(code, 0)
    return Annotation(known // CODE_BASE, known % CODE_BASE)


@dataclass(frozen=True, slots=True, eq=False)
class Objects:
    """The G objects that an evaluation counts, in a fixed order.

    Attributes:
        of_point: int64 (N,) the object of every point, -1 = void.
        label: int64 (G,) class number of every object.
    """

    of_point: Int64
    label: Int64

    def __len__(self) -> int:
        return len(self.label)

    @property
    def size(self) -> Int64:
        """Points of every object, int64 (G,)."""
        return np.bincount(self.of_point[self.of_point >= 0], minlength=len(self))


def labelled_objects(annotation: Annotation, label: Int64, valid: Bool) -> Objects:
    """Return one object per (label, number) among the ``valid`` points; the others are void.

    ``label`` (N,) is the class to give to each point. Objects come in the order of label and
    number, which is the order in which the ScanNet script visits them.
    """
    span = int(annotation.number.max(initial=0)) + 1
    code = annotation.label * span + annotation.number
    of_point = np.full(len(annotation), -1, np.int64)
    _, first, inverse = np.unique(code[valid], return_index=True, return_inverse=True)
    of_point[valid] = inverse
    return Objects(of_point, label[valid][first])


def numbered_objects(annotation: Annotation, label: int) -> Objects:
    """Return one object of class ``label`` per number, 0 = unannotated included; nothing is void.

    Points of different labels with one number are one object.
    """
    numbers, inverse = np.unique(annotation.number, return_inverse=True)
    return Objects(inverse.astype(np.int64), np.full(len(numbers), label, np.int64))
