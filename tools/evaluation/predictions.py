"""Predicted instances, before an evaluation chooses its points and classes."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from sceneq_core.arrays import Float32, Float64, Int64
from sceneq_core.evaluation.masks import PredictedMasks, disjoint_masks
from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.truth import Truth
from sceneq_tools.evaluation.vocabulary import Names, Vocabulary

REACH_M = 0.05
"""How far a map's point may be from an evaluation point that takes its instance.

The evaluation points lie 4 cm apart and a map's 2 cm, both with the noise of the depth: nearer
than this they are the same surface, and things that stand apart are farther.
"""


class Prediction(Protocol):
    """Predicted instances of one scene."""

    @property
    def source(self) -> str:
        """Where the prediction was."""

    def masks(self, truth: Truth, vocabulary: Vocabulary, reach_m: float) -> PredictedMasks:
        """Return the masks over the points of ``truth``.

        Raises:
            UserError: the two do not fit together.
        """


@dataclass(frozen=True, slots=True, eq=False)
class PredictedCloud:
    """Points that know their instance: float32 (M, 3) metres and int64 (M,), 0 = none.

    ``ids`` int64 (P,), their ``names`` and ``score`` float64 (P,) describe the instances.
    """

    source: str
    points_world: Float32
    instance_id: Int64
    ids: Int64
    names: tuple[Names, ...]
    score: Float64

    def masks(self, truth: Truth, vocabulary: Vocabulary, reach_m: float) -> PredictedMasks:
        """Give every evaluation point the instance of the nearest point within ``reach_m``."""
        if truth.points_world is None:
            hint = "give the scene's folder instead of a text file, or predictions as text"
            raise UserError(
                f"{truth.source}: truth without coordinates cannot judge a map ({hint})"
            )
        instance_id = nearest_ids(self.points_world, self.instance_id, truth.points_world, reach_m)
        return disjoint_masks(instance_id, self.ids, vocabulary.numbers(self.names), self.score)


@dataclass(frozen=True, slots=True, eq=False)
class PredictedText:
    """Masks over ``count`` numbered points: pairs (mask, point), and what each mask is."""

    source: str
    count: int
    mask: Int64
    point: Int64
    names: tuple[Names, ...]
    score: Float64

    def masks(self, truth: Truth, vocabulary: Vocabulary, reach_m: float) -> PredictedMasks:
        """Return the masks as they are: they must be about the very points of the truth."""
        if len(self.names) and self.count != len(truth):
            raise UserError(
                f"{self.source}: masks of {self.count} points, but the truth {truth.source} has "
                f"{len(truth)}"
            )
        return PredictedMasks(self.mask, self.point, vocabulary.numbers(self.names), self.score)


def nearest_ids(
    points_world: Float32, instance_id: Int64, wanted_world: Float32, reach_m: float
) -> Int64:
    """Return the id of the nearest point for every wanted one, 0 = none in reach."""
    from scipy.spatial import cKDTree

    if not len(points_world):
        return np.zeros(len(wanted_world), np.int64)
    _, nearest = cKDTree(points_world).query(wanted_world, distance_upper_bound=reach_m)
    ids = np.append(instance_id, 0)  # the tree says M where it found nothing
    return np.asarray(ids[nearest], np.int64)
