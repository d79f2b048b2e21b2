"""What reasoning is worth: never, only where the gate is unsure, always; on true instances."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sceneq_tools.evaluation.calibration import Scene
from sceneq_tools.evaluation.recording_pictures import pictures_of
from sceneq_tools.evaluation.retrieval import Retrieval, evaluate_retrieval, merged
from sceneq_tools.evaluation.retrieval_asking import MODES
from sceneq_tools.evaluation.retrieval_setup import Setup


@dataclass(frozen=True, slots=True, eq=False)
class Ablation:
    """The same questions about the same instances, one result per way to reason."""

    recordings: tuple[str, ...]
    results: tuple[Retrieval, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return everything in values that JSON knows."""
        return {
            "recordings": list(self.recordings),
            "results": [result.as_dict() for result in self.results],
        }


def evaluate_ablation(scenes: Sequence[Scene], setup: Setup) -> Ablation:
    """Ask every question once per way to reason: none, selective, always."""
    return Ablation(
        recordings=tuple(scene.questioned.name for scene in scenes),
        results=tuple(
            merged(
                [
                    result
                    for scene in scenes
                    for result in evaluate_retrieval(
                        scene.candidates,
                        scene.questioned.queries,
                        setup,
                        reasoning,
                        pictures_of(scene.questioned.folder),
                    )
                ]
            )
            for reasoning in MODES
        ),
    )
