"""Our own maps of recordings, asked the same questions as the true instances."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from sceneq_tools.evaluation.calibration import Scene
from sceneq_tools.evaluation.readers import read_truth
from sceneq_tools.evaluation.retrieval_candidates import Candidates, map_candidates
from sceneq_tools.evaluation.retrieval_queries import Questioned, read_questioned
from sceneq_tools.evaluation.retrieval_setup import Setup
from sceneq_tools.evaluation.suite_maps import MapOptions, mapped
from sceneq_tools.evaluation.suite_recordings import GIVEN, recordings_of

LEAST_IOU = 0.25
"""A poor mask of the right thing is a right answer."""


def map_scenes(
    paths: Sequence[Path],
    split: str,
    setup: Setup,
    options: MapOptions,
    quiet: bool,
    overlaps: Sequence[float] = (LEAST_IOU,),
) -> list[Scene]:
    """Return the maps of recordings, of suites those of ``split``, made unless they are there.

    A hit is an instance whose IoU with the thing is one of ``overlaps`` at least.
    """
    scenes = []
    for recording in recordings_of(paths):
        if recording.split in (split, GIVEN):
            folder = mapped(recording, options, quiet).folder
            truth = read_truth(recording.folder)
            own = map_candidates(folder, recording.folder, truth, setup, overlaps)
            scenes.append(Scene(read_questioned(recording.folder), own))
    return scenes


def judged_by(scene: Scene, overlap: float) -> Scene:
    """Return a scene with one of its rules only."""
    return _with_rule(scene.questioned, scene.candidates, f"IoU >= {overlap:g}")


def of_map(questioned: Questioned, own: Candidates) -> Scene:
    """Return a map that was judged by several rules as one judged by the most generous."""
    return _with_rule(questioned, own, list(own.matches)[-1])


def _with_rule(questioned: Questioned, own: Candidates, rule: str) -> Scene:
    return Scene(questioned, replace(own, matches={rule: own.matches[rule]}))
