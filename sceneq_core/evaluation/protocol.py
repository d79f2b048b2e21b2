"""The protocols in which instance AP is published, and what each of them counts.

They differ in more than a name, and their numbers must not be compared with each other:

========================  ==========  ================  =======================  ==============
protocol                  classes     unannotated       counted objects          IoU up to
========================  ==========  ================  =======================  ==============
``scannet200``            must match  void              in the benchmark         0.95
``own-labels``            must match  void              every label of the truth 0.95
``agnostic``              one         void              every label of the truth 0.95
``maskclustering``        one         one more object   every annotated number   0.90
========================  ==========  ================  =======================  ==============

ScanNet200 has 198 classes of instances: wall and floor are no objects in any of the protocols
but the last, where they are objects if they have a number. ScanNet's own truth knows no label but
the benchmark's: there ``own-labels`` is ``scannet200``, and ``agnostic`` counts the same objects.
The ScanNet script's own thresholds, ``arange(0.5, 0.95, 0.05)``, also end at 0.90; the paper and
its benchmark page say 0.95. ``ending_at`` gives either.

Sources: ScanNet benchmark, ``evaluate_semantic_instance.py`` (Dai et al., CVPR 2017); ScanNet200
(Rozenberszki et al., ECCV 2022, DOI 10.1007/978-3-031-19827-4_8); MaskClustering (Yan et al.,
CVPR 2024), ``evaluation/evaluate.py --no_class``.
"""

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from sceneq_core.arrays import Float64, Int64
from sceneq_core.checks import need_within
from sceneq_core.evaluation.annotation import (
    Annotation,
    Objects,
    labelled_objects,
    numbered_objects,
)

FIRST_OVERLAP, OVERLAP_STEP = 0.5, 0.05
LOOSE_OVERLAP = 0.25
ANY_CLASS = 1


@dataclass(frozen=True, slots=True)
class Protocol:
    """How truth and predictions are read before they are matched.

    Attributes:
        name: what is typed and printed.
        says: the protocol in one line.
        labels_match: a prediction is right only under the label of its object.
        unannotated_is_object: the points without annotation are one more object, not void.
        last_overlap: the strictest IoU threshold of AP.
    """

    name: str
    says: str
    labels_match: bool
    unannotated_is_object: bool
    last_overlap: float

    def __post_init__(self) -> None:
        need_within(self, FIRST_OVERLAP, 0.95, "last_overlap")

    @property
    def strict_overlaps(self) -> Float64:
        """The thresholds over which AP is the mean: 0.50, 0.55, ... ``last_overlap``."""
        steps = round((self.last_overlap - FIRST_OVERLAP) / OVERLAP_STEP)
        return np.round(FIRST_OVERLAP + OVERLAP_STEP * np.arange(steps + 1), 2)

    @property
    def overlaps(self) -> Float64:
        """All thresholds: the strict ones, then 0.25."""
        return np.append(self.strict_overlaps, LOOSE_OVERLAP)

    def ending_at(self, last_overlap: float) -> "Protocol":
        """Return this protocol with other thresholds, which its name then says."""
        if last_overlap == self.last_overlap:
            return self
        name = f"{self.name} to {last_overlap:.2f}"
        return replace(self, name=name, last_overlap=last_overlap)

    def objects(self, annotation: Annotation, classes: Collection[int]) -> Objects:
        """Return the objects that count; ``classes`` are the numbers in the benchmark."""
        if self.unannotated_is_object:
            return numbered_objects(annotation, ANY_CLASS)
        valid = np.isin(annotation.label, np.fromiter(classes, np.int64))
        return labelled_objects(annotation, self.classes_of(annotation.label), valid)

    def classes_of(self, label: Int64) -> Int64:
        """Return the class that each label (K,) counts as."""
        return label if self.labels_match else np.full_like(label, ANY_CLASS)


SCANNET200 = Protocol(
    name="scannet200",
    says="open vocabulary: labels must match; what is not in the benchmark is void",
    labels_match=True,
    unannotated_is_object=False,
    last_overlap=0.95,
)
OWN_LABELS = replace(
    SCANNET200,
    name="own-labels",
    says="open vocabulary: labels must match those of the truth; unannotated is void",
)
AGNOSTIC = Protocol(
    name="agnostic",
    says="class-agnostic: annotated objects only; unannotated is void",
    labels_match=False,
    unannotated_is_object=False,
    last_overlap=0.95,
)
MASKCLUSTERING = Protocol(
    name="maskclustering",
    says="class-agnostic, MaskClustering --no_class: unannotated points are one more object",
    labels_match=False,
    unannotated_is_object=True,
    last_overlap=0.90,
)
PROTOCOLS = {one.name: one for one in (SCANNET200, OWN_LABELS, AGNOSTIC, MASKCLUSTERING)}
