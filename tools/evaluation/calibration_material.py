"""What a calibration is fitted on: recordings as the encoder knows them, and as strangers do."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from sceneq_tools.evaluation.calibration import Scene
from sceneq_tools.evaluation.calibration_command import read_scenes
from sceneq_tools.evaluation.calibration_fit import NOTHING, Examples
from sceneq_tools.evaluation.calibration_maps import LEAST_IOU, judged_by, map_scenes
from sceneq_tools.evaluation.retrieval_setup import Setup
from sceneq_tools.evaluation.strangers import OVERLAPS, Stranger, strange_scenes
from sceneq_tools.evaluation.suite_maps import MapOptions
from sceneq_tools.suite import TUNING


@dataclass(frozen=True, slots=True)
class Material:
    """``recordings``, of suites the tuning rooms, and how they are mapped; ``true_only``: not."""

    recordings: Sequence[Path]
    options: MapOptions
    true_only: bool
    quiet: bool

    def known(self, setup: Setup) -> Examples:
        """Return what the encoder of ``setup`` sees in the recordings."""
        return Examples(self._true(setup), self._maps(setup, self.options, (LEAST_IOU,)))

    def strange(self, known: Examples, setup: Setup, strangers: Sequence[Stranger]) -> Examples:
        """Return ``known``, each thing as described by who was not taught with its model."""
        if not strangers:
            return NOTHING
        others = [replace(self.options, graph=who.graph) for who in strangers]
        maps = strange_scenes(
            self._maps(setup, self.options, OVERLAPS),
            [
                (who, self._maps(who.setup, options, (LEAST_IOU,)))
                for who, options in zip(strangers, others, strict=True)
            ],
        )
        return Examples(
            strange_scenes(known.true, [(who, self._true(who.setup)) for who in strangers]),
            tuple(judged_by(scene, LEAST_IOU) for scene in maps),
        )

    def _true(self, setup: Setup) -> tuple[Scene, ...]:
        return tuple(read_scenes(self.recordings, setup, self.quiet, TUNING))

    def _maps(
        self, setup: Setup, options: MapOptions, overlaps: Sequence[float]
    ) -> tuple[Scene, ...]:
        if self.true_only:
            return ()
        return tuple(map_scenes(self.recordings, TUNING, setup, options, self.quiet, overlaps))
