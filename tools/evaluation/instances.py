"""Instance AP of predictions against truths, in one or more protocols."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from sceneq_core.evaluation.instance_ap import MIN_REGION, InstanceAp, instance_ap
from sceneq_core.evaluation.protocol import PROTOCOLS, SCANNET200
from sceneq_core.evaluation.protocol import Protocol as ApProtocol
from sceneq_core.evaluation.surface_votes import SurfaceVotesParams
from sceneq_tools.evaluation.predictions import REACH_M, Prediction
from sceneq_tools.evaluation.readers import ScenePair, read_prediction, read_truth
from sceneq_tools.evaluation.truth import Truth
from sceneq_tools.evaluation.vocabulary import SCANNET200 as SCANNET200_VOCABULARY
from sceneq_tools.evaluation.vocabulary import Vocabulary, own_vocabulary

Scene = tuple[Prediction, Truth]
"""A prediction and the truth about the same scene, both read."""


@dataclass(frozen=True, slots=True)
class InstancesParams:
    """How instances are evaluated.

    Attributes:
        protocols: which protocols, in this order.
        min_region: points of the smallest object or prediction that counts.
        reach_m: how far a map's point may be from the evaluation point that takes its instance.
        constant_score: all instances of a map are equally sure; else the p of their label is it.
        votes: how the evaluation points of a rendered recording are found.
        truth_step: frames from one that tells the truth to the next; 1 = all of them do.
    """

    protocols: tuple[ApProtocol, ...] = tuple(PROTOCOLS.values())
    min_region: int = MIN_REGION
    reach_m: float = REACH_M
    constant_score: bool = False
    votes: SurfaceVotesParams = field(default_factory=SurfaceVotesParams)
    truth_step: int = 1

    def __post_init__(self) -> None:
        if self.truth_step < 1:
            raise ValueError(f"truth_step: expected 1 or more, got {self.truth_step}")
        if self.min_region < 1:
            raise ValueError(f"min_region: expected 1 or more, got {self.min_region}")
        if not self.reach_m > 0:
            raise ValueError(f"reach_m: must be positive, got {self.reach_m}")


@dataclass(frozen=True, slots=True, eq=False)
class InstancesReport:
    """AP in every protocol, with what it was measured on.

    Attributes:
        results: one per protocol.
        params: how it was evaluated.
        predictions: where every scene's prediction was.
        truths: what the evaluation points of every scene are.
        points: number of evaluation points in all scenes.
        outside: labels in the truth that ScanNet200 does not have; void in ``scannet200``.
    """

    results: tuple[InstanceAp, ...]
    params: InstancesParams
    predictions: tuple[str, ...]
    truths: tuple[str, ...]
    points: int
    outside: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return everything in values that JSON knows."""
        return {
            "predictions": list(self.predictions),
            "truths": list(self.truths),
            "points": self.points,
            "reach_m": self.params.reach_m,
            "score": "constant" if self.params.constant_score else "p of the label",
            "outside_scannet200": list(self.outside),
            "protocols": [one.as_dict(SCANNET200_VOCABULARY.splits) for one in self.results],
        }


def evaluate_instances(
    pairs: Sequence[ScenePair], params: InstancesParams | None = None
) -> InstancesReport:
    """Read and evaluate the scenes of ``pairs`` together.

    Raises:
        UserError: something is missing or malformed, or a prediction does not fit its truth.
    """
    params = params or InstancesParams()
    read = [
        (
            read_prediction(p, params.constant_score),
            read_truth(t, params.votes, params.truth_step),
        )
        for p, t in pairs
    ]
    return evaluate_scenes(read, params)


def evaluate_scenes(scenes: Sequence[Scene], params: InstancesParams) -> InstancesReport:
    """Evaluate scenes together that have been read, as ``params`` say, already."""
    truths = [truth for _, truth in scenes]
    return InstancesReport(
        results=tuple(_ap(scenes, protocol, params) for protocol in params.protocols),
        params=params,
        predictions=tuple(prediction.source for prediction, _ in scenes),
        truths=tuple(truth.source for truth in truths),
        points=sum(len(truth) for truth in truths),
        outside=tuple(sorted({n for t in truths for n in t.not_in(SCANNET200_VOCABULARY)})),
    )


def vocabulary_of(protocol: ApProtocol, truths: Iterable[Truth]) -> Vocabulary:
    """Return the classes of a protocol: ScanNet200's, or those in the truth."""
    if protocol.name.startswith(SCANNET200.name):
        return SCANNET200_VOCABULARY
    return own_vocabulary(names for truth in truths for names in truth.names)


def _ap(scenes: Sequence[Scene], protocol: ApProtocol, params: InstancesParams) -> InstanceAp:
    vocabulary = vocabulary_of(protocol, (truth for _, truth in scenes))
    numbered = [
        (prediction.masks(truth, vocabulary, params.reach_m), truth.annotation(vocabulary))
        for prediction, truth in scenes
    ]
    return instance_ap(numbered, vocabulary.classes, protocol, params.min_region)
