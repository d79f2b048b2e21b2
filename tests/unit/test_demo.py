"""The parts of the demo that need no graph."""

import json
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sceneq_tools import demo_text
from sceneq_tools.demo_graph import WRONG
from sceneq_tools.demo_live import example
from sceneq_tools.demo_recording import Demo, answer_marks
from sceneq_tools.demo_truth import (
    QUESTIONS,
    Question,
    Truth,
    Verdict,
    iou,
    questions_of,
    remark,
    spread,
)
from sceneq_tools.errors import UserError
from sceneq_tools.graph import load
from sceneq_tools.graph_check import check_nodes

MUG = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]
MOVED = [[5.0, 0.0, 0.0], [6.0, 1.0, 1.0]]
SOFA = [[0.0, 3.0, 0.0], [2.0, 4.0, 1.0]]


def instance(box: list[list[float]], number: int = 7) -> dict[str, Any]:
    low, high = np.array(box)
    oriented = {
        "centre": ((low + high) / 2).tolist(),
        "size": (high - low).tolist(),
        "rotation": np.eye(3).tolist(),
    }
    aabb = {"min": box[0], "max": box[1]}
    shown = {"id": number, "label": "cup", "p": 0.4, "centre": oriented["centre"]}
    return {**shown, "box_aabb": aabb, "box_oriented": oriented}


def answer(*instances: dict[str, Any], status: str = "found") -> dict[str, Any]:
    return {"status": status, "instances": list(instances), "route": "fast", "took_ms": 3.2}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    things = [
        {"id": 1, "name": "wall", "label": "wall", "stuff": True, "history": []},
        {
            "id": 2,
            "name": "mug_01",
            "label": "mug",
            "stuff": False,
            "history": [{"from_frame": 0, "box": MUG}, {"from_frame": 50, "box": MOVED}],
        },
        {
            "id": 3,
            "name": "sofa_01",
            "label": "sofa",
            "stuff": False,
            "history": [{"from_frame": 0, "box": SOFA}, {"from_frame": 90, "box": None}],
        },
    ]
    queries = [
        {"text": "mug", "bucket": "category", "targets": ["mug_01"]},
        {"text": "cup", "bucket": "category", "targets": ["mug_01"]},
        {"text": "sofa", "bucket": "category", "targets": ["sofa_01"]},
        {"text": "red mug", "bucket": "attribute", "targets": ["mug_01"]},
        {"text": "grand piano", "bucket": "absent", "targets": []},
    ]
    (tmp_path / "instances.json").write_text(json.dumps({"instances": things}))
    (tmp_path / "queries.json").write_text(json.dumps({"queries": queries}))
    return tmp_path


def test_a_folder_may_say_what_to_ask(folder: Path) -> None:
    (folder / "demo.txt").write_text("# remark\nsofa\n\nwhere is my hat\n")
    asked = questions_of(folder)
    assert [question.text for question in asked] == ["sofa", "where is my hat"]
    assert asked[0].targets is not None
    assert asked[1].targets is None


def test_questions_are_spread_over_buckets_and_targets(folder: Path) -> None:
    known = questions_of(folder)
    assert len(known) == 5
    assert [q.text for q in spread(known, 3)] == ["mug", "red mug", "grand piano"]
    assert [q.text for q in spread(known, 4)] == ["mug", "sofa", "red mug", "grand piano"]


def test_given_questions_keep_their_truth_if_the_folder_knows_them(folder: Path) -> None:
    known, unknown = questions_of(folder, ["sofa", "where is my hat"])
    assert known == Question("sofa", "category", ("sofa_01",))
    assert unknown == Question("where is my hat")


def test_a_folder_without_questions_gets_those_that_fit_anywhere(tmp_path: Path) -> None:
    assert [question.text for question in questions_of(tmp_path)] == list(QUESTIONS)
    assert Truth(tmp_path).verdict(Question("chair"), answer(), 0).right is None


@pytest.mark.parametrize("name", ["queries.json", "instances.json"])
def test_a_broken_truth_is_told_with_its_file(folder: Path, name: str) -> None:
    (folder / name).write_text("[1]")
    read = Truth if name == "instances.json" else questions_of
    with pytest.raises(UserError, match=name):
        read(folder)


def test_the_answered_box_is_compared_with_the_true_one_of_that_time(folder: Path) -> None:
    truth, mug = Truth(folder), Question("mug", "category", ("mug_01",))
    assert truth.verdict(mug, answer(instance(MUG)), 49) == Verdict(
        True, "right: the mug, boxes overlap by 1.00"
    )
    assert truth.verdict(mug, answer(instance(MUG)), 50).right is False
    assert truth.verdict(mug, answer(instance(MOVED)), 50).right is True
    wrong = truth.verdict(mug, answer(instance(SOFA), instance(MUG)), 0)
    assert wrong == Verdict(False, "wrong: that is the sofa; the right one is number 2")
    gone = truth.verdict(Question("sofa", "category", ("3",)), answer(instance(SOFA)), 95)
    assert gone.right is False


def test_absent_things_are_rightly_not_found(folder: Path) -> None:
    truth, piano = Truth(folder), Question("grand piano", "absent", ())
    assert truth.verdict(piano, answer(status="not_found"), 0).words == "rightly not found"
    assert truth.verdict(piano, answer(instance(MUG)), 0).right is False
    mug = Question("mug", "category", ("mug_01",))
    assert truth.verdict(mug, answer(status="not_found"), 0) == Verdict(False, "wrong: it is there")


def test_boxes_overlap_by_intersection_over_union() -> None:
    unit = np.array(MUG)
    assert iou(unit, unit) == 1.0
    assert iou(unit, unit + np.array([0.5, 0, 0])) == pytest.approx(1 / 3)
    assert iou(unit, unit + np.array([1.0, 0, 0])) == 0.0


@pytest.mark.parametrize("text", ["red mug", "the mug; the red one", "what's up?", "50%"])
def test_the_command_survives_a_shell_and_keeps_the_question_whole(text: str) -> None:
    words = shlex.split(demo_text.command("tcp/127.0.0.1:7447", "room", text))
    assert words[:5] == ["zenoh", "--mode", "client", "--connect", "tcp/127.0.0.1:7447"]
    selector = words[words.index("-s") + 1]
    payload = words[words.index("-v") + 1] if "-v" in words else None
    assert payload == text or selector == f"sceneq/query/room/ask?q={text}"
    assert selector.count("?") <= 1


def test_an_answer_is_one_line() -> None:
    assert demo_text.answer_line(answer(instance(MUG))) == "found: 7 cup  p 0.40  fast route, 3 ms"
    assert demo_text.answer_line(answer(status="not_found")) == "not found  fast route, 3 ms"


def test_the_score_counts_only_what_is_known() -> None:
    verdicts = [Verdict(True, ""), Verdict(False, ""), Verdict(None, "")]
    assert demo_text.score(verdicts) == "1 of 2 right"
    assert demo_text.score([Verdict(None, "")]) == "no truth to compare with"


def test_one_instance_gets_one_mark_with_all_its_questions() -> None:
    asked = [
        (Question("mug"), answer(instance(MUG)), Verdict(True, "")),
        (Question("cup"), answer(instance(MUG)), Verdict(None, "")),
        (Question("hat"), answer(status="not_found"), Verdict(True, "")),
    ]
    (mark,) = answer_marks(asked)
    assert mark.instance_id == 7
    assert mark.text == "1 “mug” p 0.40 right · 2 “cup” p 0.40"
    assert mark.corners_world.min(axis=0).tolist() == MUG[0]
    assert mark.corners_world.max(axis=0).tolist() == MUG[1]


@pytest.mark.parametrize(("frames", "every"), [(3, 1), (120, 2)])
def test_the_graph_of_the_demo_is_the_usual_one_with_keyframes_that_suit(
    tmp_path: Path, frames: int, every: int
) -> None:
    for number in range(frames):
        (tmp_path / f"frame-{number:06d}.depth.png").touch()
    (tmp_path / "frame-1.depth.png").touch()
    graph, document = load(Demo(tmp_path, tmp_path / "out", [], None, 0.0).written_graph())
    check_nodes(graph, document)
    assert graph.nodes[0].params["keyframes"] == {"kind": "every", "every": every}


@pytest.mark.parametrize(
    ("line", "wrong"),
    [
        ("08:00:00 mapping      was ended by SIGKILL", True),
        ("08:00:00 mapping      ended with exit code 1: boom", True),
        ("08:00:00 mapping      hangs (no heartbeat for 3 s): killed", True),
        ("08:00:00 up           all 7 nodes are ready after 1.9 s", False),
        ("08:00:00 ingest       finished", False),
    ],
)
def test_what_counts_as_going_wrong(line: str, wrong: bool) -> None:
    assert bool(WRONG.search(line)) == wrong


def test_the_example_of_the_live_demo_is_a_thing_on_furniture_and_another_piece() -> None:
    def thing(number: int, label: str, on_id: int, on: str) -> dict[str, Any]:
        return {"id": number, "label": label, "on_id": on_id, "on": on, "pixels": 0}

    things = [
        thing(1, "desk", 90, "floor"),
        thing(2, "shelf", 90, "floor"),
        thing(7, "cuckoo clock", 91, "wall"),
        thing(8, "stool", 92, "rug"),
        thing(92, "rug", 90, "floor"),
        thing(3, "mug", 1, "desk"),
        thing(4, "vase", 2, "shelf"),
        thing(5, "book", 1, "desk"),
        thing(6, "book", 1, "desk"),
    ]
    assert example(things) == ("mug", "shelf")
    assert example(things[:2]) == ("desk", "floor")


def test_a_choice_of_questions_says_how_it_was_made(tmp_path: Path) -> None:
    (tmp_path / "demo.txt").write_text("# These were chosen;\n# others go wrong.\n\nmug\n")
    assert remark(tmp_path) == "These were chosen; others go wrong."
    assert [question.text for question in questions_of(tmp_path)] == ["mug"]
    assert remark(tmp_path / "nowhere") == ""
