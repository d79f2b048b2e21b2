"""One recording of an evaluation: its map, its true instances, and what is asked about both."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from sceneq_core.routing.answer import FALLBACK, FAST, REASONED
from sceneq_tools.evaluation.calibration import Scene
from sceneq_tools.evaluation.instances import Scene as Judged
from sceneq_tools.evaluation.readers import read_prediction, read_truth
from sceneq_tools.evaluation.recording_pictures import pictures_of
from sceneq_tools.evaluation.retrieval import Retrieval, evaluate_retrieval, is_right
from sceneq_tools.evaluation.retrieval_asking import Answered
from sceneq_tools.evaluation.retrieval_candidates import Candidates, Matches, map_candidates
from sceneq_tools.evaluation.retrieval_command import THRESHOLDS, true_of
from sceneq_tools.evaluation.retrieval_queries import (
    QUERIES_FILE,
    Query,
    Questioned,
    read_questioned,
)
from sceneq_tools.evaluation.retrieval_setup import Setup
from sceneq_tools.evaluation.suite_maps import MapOptions, Mapped, mapped
from sceneq_tools.evaluation.suite_recordings import Recording
from sceneq_tools.evaluation.true_things import THINGS_FILE, read_things

ROUTES = (FAST, REASONED, FALLBACK)
RIGHT, WRONG = "right", "wrong"


@dataclass(frozen=True, slots=True, eq=False)
class SuiteScene:
    """Everything about a recording that numbers are made of, read once.

    Attributes:
        recording: which one.
        questioned: its things and questions.
        mapped: its map.
        judged: the predicted instances and the truth about them.
        own: the instances of the map as candidates.
        true: the true instances as candidates.
    """

    recording: Recording
    questioned: Questioned
    mapped: Mapped
    judged: Judged
    own: Candidates
    true: Candidates

    @property
    def scene(self) -> Scene:
        """Questions and true instances, as calibration and ablation take them."""
        return Scene(self.questioned, self.true)


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """The answers about one scene's candidates, scored by one rule of a hit."""

    scene: SuiteScene
    candidates: Candidates
    matches: Matches
    retrieval: Retrieval

    def is_right(self, answer: Answered) -> bool:
        """Tell whether the first match of an answer is right."""
        return is_right(answer, self.right_ids(answer.query), 1)

    def right_ids(self, query: Query) -> frozenset[int]:
        """Return the candidates that are what a question wants."""
        return frozenset(one for target in query.targets for one in self.matches.get(target, ()))


def read_suite_scene(
    recording: Recording, setup: Setup, options: MapOptions, quiet: bool = False
) -> SuiteScene:
    """Map a recording unless that was done, and read what is true of it.

    Raises:
        UserError: something is missing, malformed, or does not fit together.
    """
    questioned = questioned_of(recording.folder)
    made = mapped(recording, options, quiet)
    prediction, truth = read_prediction(made.folder), read_truth(recording.folder)
    return SuiteScene(
        recording=recording,
        questioned=questioned,
        mapped=made,
        judged=(prediction, truth),
        own=map_candidates(made.folder, recording.folder, truth, setup, THRESHOLDS),
        true=true_of(questioned, setup.seeing(recording.every), quiet),
    )


def questioned_of(folder: Path) -> Questioned:
    """Return things and questions of a recording; without queries.json only its things."""
    if (folder / QUERIES_FILE).is_file():
        return read_questioned(folder)
    things = read_things(folder / THINGS_FILE)
    digest = hashlib.sha256((folder / THINGS_FILE).read_bytes()).hexdigest()
    return Questioned(folder, things, (), digest)


def ask(scene: SuiteScene, setup: Setup) -> tuple[Asked, ...]:
    """Ask about the true instances, and about the map; one result for every rule of a hit."""
    queries, pictures = scene.questioned.queries, pictures_of(scene.questioned.folder)
    return tuple(
        Asked(scene, candidates, candidates.matches[result.hit_rule], result)
        for candidates in (scene.true, scene.own)
        for result in evaluate_retrieval(candidates, queries, setup, pictures=pictures)
    )


def route_counts(asked: Sequence[Asked]) -> Mapping[str, Mapping[str, int]]:
    """Return how many answers of each route were right and wrong."""
    counts = {route: {RIGHT: 0, WRONG: 0} for route in ROUTES}
    for one in asked:
        for answer in one.retrieval.answers:
            counts[answer.route][RIGHT if one.is_right(answer) else WRONG] += 1
    return counts
