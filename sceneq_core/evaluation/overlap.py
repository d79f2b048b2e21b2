"""How many points predictions and objects of one class share."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int64
from sceneq_core.evaluation.annotation import Objects
from sceneq_core.evaluation.masks import PredictedMasks


@dataclass(frozen=True, slots=True, eq=False)
class Overlap:
    """Shared points of P predictions and G objects, as the K pairs that share any.

    Attributes:
        prediction: int64 (K,) 0 to P - 1; within an object the predictions come in order.
        object: int64 (K,) 0 to G - 1, ascending.
        shared: int64 (K,) points in both.
        prediction_size: int64 (P,) points of every prediction.
        object_size: int64 (G,) points of every object.
        void: int64 (P,) points of every prediction that are void.
        score: float64 (P,) confidence of every prediction.
    """

    prediction: Int64
    object: Int64
    shared: Int64
    prediction_size: Int64
    object_size: Int64
    void: Int64
    score: Float64

    @property
    def iou(self) -> Float64:
        """Intersection over union of every pair, float64 (K,)."""
        sizes = self.prediction_size[self.prediction] + self.object_size[self.object]
        return self.shared / (sizes - self.shared)

    def of_class(self, predictions: Bool, objects: Bool) -> "Overlap":
        """Return what concerns the chosen ``predictions`` (P,) and ``objects`` (G,) only."""
        pairs = predictions[self.prediction] & objects[self.object]
        return Overlap(
            prediction=(np.cumsum(predictions) - 1)[self.prediction[pairs]],
            object=(np.cumsum(objects) - 1)[self.object[pairs]],
            shared=self.shared[pairs],
            prediction_size=self.prediction_size[predictions],
            object_size=self.object_size[objects],
            void=self.void[predictions],
            score=self.score[predictions],
        )


def overlap(masks: PredictedMasks, objects: Objects) -> Overlap:
    """Count the shared points of all predictions and objects, whatever their class.

    Raises:
        ValueError: a mask has a point that the truth does not know.
    """
    if len(masks.point) and not 0 <= masks.point.min() <= masks.point.max() < len(objects.of_point):
        raise ValueError(f"point: masks reach beyond the {len(objects.of_point)} points of truth")
    # Column 0 counts void, column g + 1 object g.
    columns = len(objects) + 1
    cell = (objects.of_point[masks.point] + 1) * len(masks) + masks.mask
    table = np.bincount(cell, minlength=columns * len(masks)).reshape(columns, len(masks))
    object_index, prediction = np.nonzero(table[1:])
    return Overlap(
        prediction=prediction,
        object=object_index,
        shared=table[1:][object_index, prediction],
        prediction_size=masks.size,
        object_size=objects.size,
        void=table[0],
        score=masks.score,
    )
