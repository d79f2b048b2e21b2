"""Everything that is measured, over all recordings: one document."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sceneq_tools.evaluation.ablation import evaluate_ablation
from sceneq_tools.evaluation.calibration import evaluate_calibration
from sceneq_tools.evaluation.calibration_fit import QUESTIONS, Fitted, fit
from sceneq_tools.evaluation.calibration_maps import of_map
from sceneq_tools.evaluation.instances import InstancesParams, evaluate_scenes
from sceneq_tools.evaluation.retrieval import merged
from sceneq_tools.evaluation.retrieval_setup import Setup
from sceneq_tools.evaluation.suite_recordings import GIVEN, SPLITS
from sceneq_tools.evaluation.suite_scene import Asked, SuiteScene, ask, route_counts
from sceneq_tools.suite import TEST, TUNING

Json = dict[str, Any]

CONFIGURED, FITTED = "configured", "fitted"
"""As the graph says, and with temperature and gate fitted on the tuning rooms."""


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """The measures of all recordings.

    Attributes:
        document: what report.json holds of them.
        scenes: what was measured.
        fitted: the calibration of the tuning rooms; ``None`` without such rooms.
        asked: the answers as configured, for pictures of those that are wrong.
    """

    document: Json
    scenes: tuple[SuiteScene, ...]
    fitted: Fitted | None
    asked: tuple[Asked, ...]


def evaluate(scenes: Sequence[SuiteScene], setup: Setup) -> Evaluation:
    """Measure instances, retrieval, calibration and reasoning.

    What is fitted is fitted on the tuning rooms, and used on the other recordings only.
    """
    by_split = {split: [one for one in scenes if one.recording.split == split] for split in SPLITS}
    fitted = _fitted(by_split[TUNING], setup)
    setups = {CONFIGURED: setup}
    if fitted is not None:
        setups[FITTED] = setup.with_calibration(fitted.calibration)
    asked = {
        name: [result for scene in _askable(scenes, name) for result in ask(scene, one)]
        for name, one in setups.items()
    }
    measured = {split: by_split[split] for split in (TEST, GIVEN) if by_split[split]}
    together = {f"{TEST} and {GIVEN}": [*by_split[TEST], *by_split[GIVEN]]}
    calibrated = {**measured, **together} if len(measured) > 1 else measured
    document = {
        "recordings": [_recording(scene, asked[CONFIGURED]) for scene in scenes],
        "instances": {split: _instances(some) for split, some in by_split.items() if some},
        "retrieval": [row for name, some in asked.items() for row in _retrieval(name, some)],
        "calibration": [
            {"split": split, "setting": name, **evaluate_calibration(_plain(some), one).as_dict()}
            for split, some in calibrated.items()
            for name, one in setups.items()
        ],
        "fitted": fitted and fitted.as_dict(),
        "ablation": [
            {"split": split, "setting": name, **_ablation(some, one)}
            for split, some in measured.items()
            for name, one in setups.items()
        ],
    }
    return Evaluation(document, tuple(scenes), fitted, tuple(asked[CONFIGURED]))


def _fitted(scenes: Sequence[SuiteScene], setup: Setup) -> Fitted | None:
    maps = [of_map(one.questioned, one.own) for one in scenes]
    return fit(_plain(scenes), setup, QUESTIONS, maps) if scenes else None


def _askable(scenes: Iterable[SuiteScene], setting: str) -> list[SuiteScene]:
    """Return the scenes that a setting may be measured on: not on those it was fitted on."""
    return [one for one in scenes if setting == CONFIGURED or one.recording.split != TUNING]


def _plain(scenes: Iterable[SuiteScene]) -> list[Any]:
    return [scene.scene for scene in scenes]


def _instances(scenes: Sequence[SuiteScene]) -> Json:
    return evaluate_scenes([scene.judged for scene in scenes], InstancesParams()).as_dict()


def _retrieval(setting: str, asked: Sequence[Asked]) -> Iterable[Json]:
    """Yield one record for every split, kind of candidates and rule of a hit."""
    for split in SPLITS:
        chosen = [one for one in asked if one.scene.recording.split == split]
        kinds = dict.fromkeys((one.candidates.name, one.retrieval.hit_rule) for one in chosen)
        for kind in kinds:
            some = [o for o in chosen if (o.candidates.name, o.retrieval.hit_rule) == kind]
            summed = merged([one.retrieval for one in some]).as_dict()
            del summed["answers"]  # they stand with their recordings
            routes = route_counts(some)
            yield {"split": split, "setting": setting, "routes": routes, **summed}


def _ablation(scenes: Sequence[SuiteScene], setup: Setup) -> Json:
    document = evaluate_ablation(_plain(scenes), setup).as_dict()
    for result in document["results"]:
        del result["answers"]
    return document


def _recording(scene: SuiteScene, asked: Sequence[Asked]) -> Json:
    one, made = scene.recording, scene.mapped
    prediction, truth = scene.judged
    return {
        "name": one.name,
        "split": one.split,
        "made_by": one.made_by,
        "sha256": scene.questioned.sha256,
        "frames": made.frames,
        "keyframes": made.keyframes,
        "things": len(scene.true.snapshot),
        "unseen_things": len(scene.true.snapshot.waiting),
        "questions": len(scene.questioned.queries),
        "truth_points": len(truth),
        "map": {
            "source": prediction.source,
            "key": made.key,
            "was_there": made.was_there,
            "instances": len(scene.own.snapshot),
            "troubles": made.troubles,
            "taken_ms": made.taken_ms,
        },
        "instances": _instances([scene]),
        "retrieval": [o.retrieval.as_dict() for o in asked if o.scene is scene],
    }


def stage_times(recordings: Iterable[Mapping[str, Any]]) -> dict[str, float]:
    """Return what each stage took a keyframe, ms, over all maps."""
    recordings = list(recordings)
    keyframes = max(sum(one["keyframes"] for one in recordings), 1)
    stages = dict.fromkeys(stage for one in recordings for stage in one["map"]["taken_ms"])
    return {
        stage: sum(one["map"]["taken_ms"].get(stage, 0.0) for one in recordings) / keyframes
        for stage in stages
    }
