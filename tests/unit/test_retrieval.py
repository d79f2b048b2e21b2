"""Hit@k per bucket of questions, asked at the front door."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from sceneq_core.routing.gate import GateParams
from sceneq_core.routing.judge import JudgeParams
from sceneq_core.routing.router import RouterParams
from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.ablation import evaluate_ablation
from sceneq_tools.evaluation.calibration import Scene
from sceneq_tools.evaluation.retrieval import Answered, evaluate_retrieval, is_right, merged
from sceneq_tools.evaluation.retrieval_asking import ALWAYS, NONE, SELECTIVE, Asking
from sceneq_tools.evaluation.retrieval_candidates import Candidates
from sceneq_tools.evaluation.retrieval_queries import Query, Questioned, read_questioned

from support.furnished import WordEncoder, ids, router, snapshot
from support.questioned import hash_setup, write_questioned

LAMP, CHAIRS = ids("lamp"), ids("chair")
SCENE = snapshot()
EVERY_ID = {one.instance_id: frozenset([one.instance_id]) for one in SCENE.instances}
HERE = Candidates("true instances", SCENE, {"exact": EVERY_ID})
QUERIES = (
    Query("lamp", "category", frozenset(LAMP)),
    Query("the trash can next to the coffee table", "spatial", frozenset(ids("trash can"))),
    Query("box", "category", frozenset(CHAIRS)),  # a wrong answer key: never a hit
    Query("grand piano", "absent", frozenset()),
)


def setup(gate: GateParams | None = None):
    params = RouterParams(judge=JudgeParams(gate=gate or GateParams()))
    return replace(hash_setup(), encoder=WordEncoder(), router=router(params))


def answered(query: Query, status: str, ranked: tuple[int, ...]) -> Answered:
    return Answered(query, status, "fast", ranked, 1.0, 0, "")


def test_a_hit_is_a_target_among_the_best_whatever_the_status():
    query = Query("chair", "category", frozenset([3, 4]))
    second = answered(query, "ambiguous", (9, 4, 1))
    assert not is_right(second, frozenset([3, 4]), 1)
    assert is_right(second, frozenset([3, 4]), 5)
    assert is_right(answered(query, "not_found", (4,)), frozenset([3, 4]), 1)
    assert not is_right(answered(query, "found", ()), frozenset([3, 4]), 5)


def test_absent_is_right_when_it_is_not_found():
    absent = Query("bathtub", "absent", frozenset())
    assert is_right(answered(absent, "not_found", (1, 2)), frozenset(), 1)
    assert not is_right(answered(absent, "ambiguous", (1, 2)), frozenset(), 5)


def test_buckets_by_hand():
    (result,) = evaluate_retrieval(HERE, QUERIES, setup())
    category, spatial, absent = (result.bucket(n) for n in ("category", "spatial", "absent"))
    assert (category.questions, category.hit_1, category.unreachable) == (2, 1, 0)
    assert (spatial.questions, spatial.hit_1, spatial.reasoned, spatial.fast) == (1, 1, 1, 0)
    assert (absent.questions, absent.hit_1, absent.not_found) == (1, 1, 1)
    assert [one.bucket for one in result.buckets] == [
        "category", "spatial", "absent", "present", "all",
    ]  # fmt: skip
    total = result.bucket("all")
    assert (total.questions, total.hit_1) == (4, 3)
    assert total.fast + total.reasoned + total.fallback == 4
    assert result.bucket("present").questions == 3
    assert result.wrongly_not_found == 0
    assert result.bucket("affordance") is None
    json.dumps(result.as_dict())


def test_what_is_no_candidate_cannot_be_hit():
    no_lamp = {key: value for key, value in EVERY_ID.items() if key not in LAMP}
    (result,) = evaluate_retrieval(Candidates("map", SCENE, {"IoU": no_lamp}), QUERIES, setup())
    assert (result.bucket("category").hit_1, result.bucket("category").unreachable) == (0, 1)


def test_each_rule_scores_the_same_answers():
    rules = {"strict": {}, "loose": EVERY_ID}
    strict, loose = evaluate_retrieval(Candidates("map", SCENE, rules), QUERIES, setup())
    assert strict.answers is loose.answers
    assert (strict.bucket("present").hit_1, loose.bucket("present").hit_1) == (0, 2)


def test_reasoning_happens_when_it_is_told_to():
    spatial, lamp = QUERIES[1], QUERIES[0]
    asking = Asking(setup(), SCENE)
    assert asking.ask(spatial, NONE).route == "fast"
    assert asking.ask(spatial, SELECTIVE).route == "reasoned"
    assert asking.ask(lamp, SELECTIVE).route == "fast"
    assert asking.ask(lamp, ALWAYS).route == "reasoned"


def test_a_strict_gate_sends_more_to_the_reasoner():
    shut = setup(GateParams(min_p=1.0))
    assert Asking(shut, SCENE).ask(QUERIES[0], SELECTIVE).route == "reasoned"


def test_results_of_several_scenes_add_up():
    (one,) = evaluate_retrieval(HERE, QUERIES, setup())
    (two,) = evaluate_retrieval(HERE, QUERIES[:1], setup())
    both = merged([one, two])
    assert both.bucket("category").questions == 3
    assert both.bucket("category").hit_1 == 2
    assert both.bucket("absent") == one.bucket("absent")
    assert len(both.answers) == 5


def test_the_ablation_asks_all_in_three_ways():
    questioned = Questioned(Path("room"), (), QUERIES, "0" * 64)
    ablation = evaluate_ablation([Scene(questioned, HERE)], setup())
    assert [result.reasoning for result in ablation.results] == ["none", "selective", "always"]
    none, selective, always = (result.bucket("all") for result in ablation.results)
    assert none.reasoned == 0 < selective.reasoned < always.reasoned == 4
    assert none.hit_1 <= selective.hit_1
    json.dumps(ablation.as_dict())


def test_questions_are_read_with_ids_for_names(tmp_path: Path):
    read = read_questioned(write_questioned(tmp_path / "room", 1) / "queries.json")
    assert read.name == "room"
    assert read.queries[0] == Query("red ball", "attribute", frozenset([4]))
    assert read.queries[3].is_absent
    assert len(read.sha256) == 64


@pytest.mark.parametrize(
    ("queries", "complaint"),
    [
        ([{"text": "a", "bucket": "category", "targets": ["nothing"]}], "no thing 'nothing'"),
        ([{"text": "a", "targets": []}], "no field 'bucket'"),
        ([{"text": "a", "bucket": "absent", "targets": ["table"]}], "targets"),
        ([{"text": "a", "bucket": "category", "targets": []}], "targets"),
        ([7], "queries.json: queries.0."),
        (7, "expected a list"),
    ],
)
def test_bad_questions_are_named(tmp_path: Path, queries, complaint):
    folder = write_questioned(tmp_path / "room", 1)
    (folder / "queries.json").write_text(json.dumps({"queries": queries}))
    with pytest.raises(UserError, match=complaint):
        read_questioned(folder)


def test_a_folder_without_questions_is_named(tmp_path: Path):
    folder = write_questioned(tmp_path / "room", 1)
    (folder / "queries.json").unlink()
    with pytest.raises(UserError, match=r"queries\.json"):
        read_questioned(folder)
