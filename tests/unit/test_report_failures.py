"""Which wrong answers are shown, and that their boxes are where the things are."""

import base64
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from sceneq_tools.evaluation.report_failures import (
    RIGHT_BGR,
    WRONG_BGR,
    data_uri,
    failure_record,
    pictures,
    worst,
)
from sceneq_tools.evaluation.retrieval_command import true_of
from sceneq_tools.evaluation.retrieval_queries import read_questioned
from sceneq_tools.evaluation.suite_maps import Mapped
from sceneq_tools.evaluation.suite_recordings import Recording
from sceneq_tools.evaluation.suite_scene import Asked, SuiteScene, ask, route_counts

from support.questioned import IDS, hash_setup, instance_of, write_questioned

FRAMES = 4
SETUP = hash_setup()
RED, YELLOW = IDS["red ball"], IDS["yellow ball"]
QUERIES = (("red ball", "attribute", ["red ball"]), ("yellow ball", "attribute", ["yellow ball"]))


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> SuiteScene:
    """True instances as a map in which the two balls were taken for each other."""
    folder = write_questioned(tmp_path_factory.mktemp("f") / "room", FRAMES, QUERIES)
    questioned = read_questioned(folder)
    true = true_of(questioned, SETUP, quiet=True)
    swapped = {**next(iter(true.matches.values()))}
    swapped[RED], swapped[YELLOW] = swapped[YELLOW], swapped[RED]
    own = replace(true, name="map", matches={"IoU >= 0.25": swapped})
    mapped = Mapped(folder, "key", FRAMES, FRAMES, {}, 0.0, {}, False)
    recording = Recording("room", folder, "test", 1)
    return SuiteScene(recording, questioned, mapped, (None, None), own, true)  # type: ignore[arg-type]


def asked_of(scene: SuiteScene, name: str) -> Asked:
    return next(one for one in ask(scene, SETUP) if one.candidates.name == name)


def test_a_right_answer_is_no_failure_and_a_wrong_one_is(scene: SuiteScene) -> None:
    right, wrong = asked_of(scene, "true instances"), asked_of(scene, "map")
    assert not worst([right], SETUP)
    failures = worst([wrong], SETUP)
    assert {one.answer.query.text for one in failures} == {"red ball", "yellow ball"}
    assert failures[0].p >= failures[1].p
    assert len(worst([wrong], SETUP, count=1)) == 1
    counts = route_counts([right, wrong])
    assert sum(one["right"] for one in counts.values()) == 2
    assert sum(one["wrong"] for one in counts.values()) == 2


def test_what_nothing_could_answer_is_left_out(scene: SuiteScene) -> None:
    asked = replace(asked_of(scene, "map"), matches={})
    assert not worst([asked], SETUP)


def test_boxes_are_where_the_things_are(scene: SuiteScene) -> None:
    failure = next(
        one for one in worst([asked_of(scene, "map")], SETUP) if one.answer.query.text == "red ball"
    )
    assert failure.answered is not None
    assert failure.answered.instance_id == RED  # which the swapped matches call the yellow one
    (says, evidence), (also_says, best) = pictures(failure)
    assert (says, also_says) == ("answered", "right")
    seq = failure.answered.views[0].seq
    rows, columns = np.nonzero(instance_of(seq, FRAMES) == RED)
    marked = (evidence == WRONG_BGR).all(axis=2)
    assert marked.any()
    assert abs(np.nonzero(marked)[0].mean() - rows.mean()) < 8
    assert abs(np.nonzero(marked)[1].mean() - columns.mean()) < 8
    assert (best == RIGHT_BGR).all(axis=2).any()


def test_a_failure_is_told_in_words(scene: SuiteScene) -> None:
    record = failure_record(worst([asked_of(scene, "map")], SETUP, count=1)[0])
    assert record["recording"] == "room"
    assert record["right"] in (["red ball"], ["yellow ball"])
    assert len(record["pictures"]) == 2


def test_a_picture_travels_as_a_data_uri() -> None:
    image = np.full((30, 60, 3), (10, 120, 240), np.uint8)
    head, _, body = data_uri(image, 40).partition(",")
    assert head == "data:image/jpeg;base64"
    back = cv2.imdecode(np.frombuffer(base64.b64decode(body), np.uint8), cv2.IMREAD_COLOR)
    assert back.shape == (20, 40, 3)
    assert np.abs(back.astype(int) - (10, 120, 240)).max() < 12


def test_a_frame_that_is_gone_is_grey(scene: SuiteScene, tmp_path: Path) -> None:
    recording = replace(scene.recording, folder=tmp_path)
    gone = replace(scene, recording=recording)
    failure = worst([replace(asked_of(scene, "map"), scene=gone)], SETUP, count=1)[0]
    images = list(scene.recording.folder.glob("frame-*.instance.png"))
    for path in images:
        (tmp_path / path.name).write_bytes(path.read_bytes())
    (_, evidence), *_ = pictures(failure)
    assert (evidence[0, 0] == 200).all()
