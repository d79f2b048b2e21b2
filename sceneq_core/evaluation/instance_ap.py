"""Average precision of instances, over scenes, classes and IoU thresholds."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sceneq_core.arrays import Array, Float64
from sceneq_core.evaluation.annotation import Annotation
from sceneq_core.evaluation.masks import PredictedMasks
from sceneq_core.evaluation.matching import match, together
from sceneq_core.evaluation.overlap import Overlap, overlap
from sceneq_core.evaluation.precision_recall import average_precision
from sceneq_core.evaluation.protocol import ANY_CLASS, LOOSE_OVERLAP, Protocol

MIN_REGION = 100
"""Points of the smallest object or prediction that counts, as in ScanNet."""
ANY_NAME = "object"


@dataclass(frozen=True, slots=True, eq=False)
class ClassAp:
    """AP of one class.

    Attributes:
        name: of the class.
        ap: float64 (T,) at every threshold of the protocol, the loose one last; NaN = the class
            has no object that counts, so that its predictions are not held against anyone.
        objects: objects that count.
        predictions: predictions that count.
    """

    name: str
    ap: Float64
    objects: int
    predictions: int

    @property
    def means(self) -> Float64:
        """AP over the strict thresholds, AP50 and AP25, float64 (3,)."""
        return np.array([self.ap[:-1].mean(), self.ap[0], self.ap[-1]])


@dataclass(frozen=True, slots=True, eq=False)
class InstanceAp:
    """The outcome of an evaluation: what was counted how, and AP per class.

    Means over classes leave out classes without objects. With no class left they are NaN.
    """

    protocol: Protocol
    min_region: int
    scenes: int
    classes: tuple[ClassAp, ...]

    @property
    def objects(self) -> int:
        """Objects that count."""
        return sum(one.objects for one in self.classes)

    @property
    def predictions(self) -> int:
        """Predictions that count, also those of classes without an object."""
        return sum(one.predictions for one in self.classes)

    @property
    def means(self) -> Float64:
        """AP, AP50 and AP25 over all classes with objects, float64 (3,)."""
        return self.means_of([one.name for one in self.classes])

    def means_of(self, names: Collection[str]) -> Float64:
        """Return AP, AP50 and AP25 over those of the named classes that have objects."""
        chosen = [one.means for one in self.classes if one.name in names and one.objects]
        return np.mean(chosen, axis=0) if chosen else np.full(3, np.nan)

    def as_dict(self, splits: Mapping[str, Collection[str]] | None = None) -> dict[str, Any]:
        """Return everything in values that JSON knows; ``splits`` names groups of classes.

        Where labels do not count there is one class, and no group of classes to speak of.
        """
        groups = (splits or {}) if self.protocol.labels_match else {}
        return {
            "protocol": self.protocol.name,
            "rules": self.protocol.says,
            "overlaps": [*self.protocol.strict_overlaps.tolist(), LOOSE_OVERLAP],
            "min_region": self.min_region,
            "scenes": self.scenes,
            "objects": self.objects,
            "predictions": self.predictions,
            **_means_dict(self.means),
            "splits": {name: _means_dict(self.means_of(names)) for name, names in groups.items()},
            "classes": {one.name: _class_dict(one) for one in self.classes},
        }


def instance_ap(
    scenes: Sequence[tuple[PredictedMasks, Annotation]],
    classes: Mapping[int, str],
    protocol: Protocol,
    min_region: int = MIN_REGION,
) -> InstanceAp:
    """Return AP of the predicted masks of every scene against what is annotated there.

    Predictions and objects are gathered over all scenes before the curve of a class is drawn, and
    matched within their scene by the rules of ``matching``. A class with objects but no judged
    prediction has AP 0, one without objects has none.

    Args:
        scenes: masks and truth over the same points, scene by scene.
        classes: number and name of every class in the benchmark; predictions of other numbers
            are left out, points of other numbers are void (where the protocol knows void).
        protocol: which of the protocols.
        min_region: points of the smallest object and prediction that counts.

    Raises:
        ValueError: ``min_region`` below 1, or masks with points that the truth does not have.
    """
    if min_region < 1:
        raise ValueError(f"min_region: expected 1 or more, got {min_region}")
    named = classes if protocol.labels_match else {ANY_CLASS: ANY_NAME}
    counted = [
        _CountedScene(masks, truth, classes, protocol, min_region) for masks, truth in scenes
    ]
    results = tuple(_classes_ap(counted, named, protocol, min_region))
    return InstanceAp(protocol, min_region, len(scenes), results)


class _CountedScene:
    """The overlaps of one scene, and the class of everything in it."""

    def __init__(
        self,
        masks: PredictedMasks,
        truth: Annotation,
        classes: Collection[int],
        protocol: Protocol,
        min_region: int,
    ) -> None:
        objects = protocol.objects(truth, classes)
        self._overlap = overlap(masks, objects)
        self._object_class = objects.label
        self._class = protocol.classes_of(masks.label)
        self._counts = self._overlap.prediction_size >= min_region

    def of_class(self, number: int) -> Overlap:
        """Return what concerns one class, predictions that are too small left out."""
        predictions = self._counts & (self._class == number)
        return self._overlap.of_class(predictions, self._object_class == number)

    def present(self) -> Array:
        """Return the class numbers of objects and predictions that stand here."""
        return np.union1d(self._object_class, self._class[self._counts])


def _classes_ap(
    scenes: Sequence[_CountedScene], names: Mapping[int, str], protocol: Protocol, min_region: int
) -> Iterator[ClassAp]:
    present = {int(number) for scene in scenes for number in scene.present()}
    for number, name in names.items():
        if number in present:
            yield _class_ap(name, [s.of_class(number) for s in scenes], protocol, min_region)


def _class_ap(name: str, scenes: Iterable[Overlap], protocol: Protocol, min_region: int) -> ClassAp:
    scenes = tuple(scenes)
    objects = sum(int((scene.object_size >= min_region).sum()) for scene in scenes)
    predictions = sum(len(scene.score) for scene in scenes)
    ap = np.full(len(protocol.overlaps), np.nan)
    if objects:
        ap = np.array([_ap(scenes, float(iou), min_region) for iou in protocol.overlaps])
    return ClassAp(name, ap, objects, predictions)


def _ap(scenes: Sequence[Overlap], threshold: float, min_region: int) -> float:
    return average_precision(together(match(one, threshold, min_region) for one in scenes))


def _class_dict(one: ClassAp) -> dict[str, Any]:
    counts = {"objects": one.objects, "predictions": one.predictions}
    return {**counts, **_means_dict(one.means)}


def _means_dict(means: Float64) -> dict[str, float | None]:
    names = ("ap", "ap50", "ap25")
    pairs = zip(names, means.tolist(), strict=True)
    return {name: None if np.isnan(value) else value for name, value in pairs}
