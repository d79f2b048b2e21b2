"""Every form of question at the front door of a furnished room: facts, and a sentence."""

import json
from dataclasses import replace

import cv2
import jsonschema
import numpy as np
import pytest

from sceneq_core.reasoning.geometric import GeometricParams, GeometricReasoner
from sceneq_core.reasoning.reasoner import LabelVerdict
from sceneq_core.routing import forms
from sceneq_core.routing.revision import Revision
from sceneq_nodes._bus import QueryError, Request
from sceneq_nodes._front_door import FrontDoor
from sceneq_nodes._look import Look
from sceneq_schemas.answer import ANSWER, FORMS
from sceneq_schemas.topics import QUERY_ASK, QUERY_INSTANCES, QUERY_LABEL

from support.furnished import ROOM, UP, Thing, WordEncoder, furnish, ids, instance, router

FLOOR, WALL = 1, 2
RESTS_ON = {4: 3, 6: 5, 7: 8, 9: WALL}
ROLES = {"floor": "floor", "wall": "wall"}
SECOND_NS = 1_000_000_000
RED_CUP, BLUE_CUP = 6, 7


def built():
    """The room as the map knows it: roles, and what stands on what; seen 60 s after the start."""
    return [
        replace(
            instance(key, thing),
            role=ROLES.get(thing.name, "object"),
            supported_by=RESTS_ON.get(key, FLOOR if key > WALL else 0),
            last_seen_ns=50 * SECOND_NS,
        )
        for key, thing in enumerate(ROOM, 1)
    ]


def room(noise=0.3):
    scene = furnish(noise=noise)
    scene.apply_map(Revision(5, 13, 111, 60 * SECOND_NS), built(), UP, full=True)
    return scene


def emptied(*keys):
    """The room after something was carried away, 10 s later."""
    scene = room()
    gone = [replace(one, state="removed") for one in built() if one.instance_id in keys]
    scene.apply_map(Revision(5, 14, 112, 70 * SECOND_NS), gone, UP, full=False)
    return scene


def door(scene, **given):
    look = Look(scene.snapshot(), 0.0)
    reasoner = GeometricReasoner(GeometricParams())
    return FrontDoor("room", router(), lambda: look, reasoner.solve, dict, **given)


def ask(text, scene=None, **parameters):
    request = Request(QUERY_ASK, "", {}, False, {"q": text, **parameters})
    answer = json.loads(door(scene or room()).ask(request).payload)
    jsonschema.validate(answer, ANSWER)
    return answer


@pytest.fixture(scope="module")
def seen():
    return room()


def test_where_tells_support_and_landmark(seen):
    answer = ask("where is the blue cup?", seen)
    assert (answer["status"], answer["form"]) == ("found", "where")
    where = answer["where"]
    assert where["on"] == {"id": 8, "label": "kitchen counter"}
    assert where["near"] == {"id": 12, "label": "chair", "distance_m": 1.274}
    said = "The blue cup (7) is on the kitchen counter, 1.3 m from the chair."
    assert answer["said"] == said


def test_counting_lists_all_of_them(seen):
    answer = ask("how many chairs are there?", seen, k="1")
    assert (answer["status"], answer["form"], answer["said"]) == ("found", "count", "3 chairs.")
    assert answer["count"]["sure"] == 3
    assert set(answer["count"]["sure_ids"]) == ids("chair")
    assert [one["id"] for one in answer["instances"]] == answer["count"]["sure_ids"]
    assert 2 < answer["count"]["expected"] <= 3


def test_counting_where_something_is(seen):
    answer = ask("how many cups are on the kitchen counter", seen)
    assert answer["count"]["sure_ids"] == [BLUE_CUP]
    assert answer["said"] == "1 cup on the kitchen counter."


def test_a_kind_of_it_counts(seen):
    answer = ask("how many tables", seen)
    assert set(answer["count"]["sure_ids"]) == ids("table")
    small = ask("how many small tables", seen)["count"]
    assert (small["sure_ids"], small["possible"]) == ([5], 1)


def test_parts_of_the_building_are_counted_as_the_map_knows_them(seen):
    assert ask("how many walls are there", seen)["count"]["sure_ids"] == [WALL]


def test_a_weak_encoder_counts_carefully():
    answer = ask("how many chairs", room(noise=1.5))
    assert answer["count"]["sure"] == 0
    assert answer["status"] in ("ambiguous", "not_found")
    assert "for sure" in answer["said"] or answer["said"].startswith("There is no chair")


def test_nothing_to_count(seen):
    answer = ask("how many bicycles", seen)
    assert answer["status"] == "not_found"
    assert answer["count"] == {
        "sure": 0, "possible": 0, "expected": 0.0, "sure_ids": [], "possible_ids": [],
    }  # fmt: skip
    assert answer["missing"] == "bicycle"


def test_what_lists_everything_in_that_place(seen):
    answer = ask("what is on the kitchen counter?", seen)
    assert (answer["status"], answer["form"]) == ("found", "what")
    assert [one["id"] for one in answer["instances"]] == [BLUE_CUP]
    assert answer["said"] == "On the kitchen counter: the cup (7)."
    assert answer["route"] == "fast"
    beside = ask("what is next to the coffee table", seen)
    # The encoder is not sure of the table, and so of nothing beside it.
    assert beside["count"]["sure_ids"] == []
    assert beside["count"]["possible_ids"][0] == 10


def test_anything_is_there_however_vague_it_looks():
    """Things that look like words for anything do not make "what" a thing that is missing."""
    vague = [Thing("object", (x, 2.2, 0.95), (x + 0.1, 2.3, 1.05)) for x in (1.0, 1.5)]
    answer = ask("what is on the kitchen counter?", furnish((*ROOM[:6], ROOM[7], *vague)))
    assert answer["status"] == "found"
    assert answer["count"]["sure_ids"] == [8, 9]


def test_nothing_is_there(seen):
    answer = ask("what is on the trash can", seen)
    assert answer["status"] == "not_found"
    assert answer["said"] == "Nothing on the trash can, as far as the map shows."


def test_a_place_that_does_not_exist(seen):
    answer = ask("what is on the bicycle", seen)
    assert (answer["status"], answer["missing"]) == ("not_found", "bicycle")
    assert answer["said"] == "There is no bicycle."


@pytest.mark.parametrize(
    ("text", "exists", "said"),
    [
        ("is there a lamp?", "yes", "Yes: the likeliest lamp is the lamp (16) on the floor"),
        ("are there any chairs?", "yes", "Yes: the likeliest chair is"),
        ("is there a bathtub", "no", "There is no bathtub; the nearest miss is"),
        ("is there a chair near the dining table", "yes", "Yes: the likeliest chair near the"),
        ("is there a lamp on the coffee table", "no", "There is no lamp on the coffee table"),
    ],
)
def test_existence(seen, text, exists, said):
    answer = ask(text, seen)
    assert (answer["form"], answer["exists"]) == ("exists", exists)
    assert answer["said"].startswith(said)


def test_a_weak_encoder_is_unsure_of_existence():
    assert ask("is there a chair", room(noise=2.2))["exists"] == "unsure"


def test_what_is_not_there_has_a_nearest_miss(seen):
    answer = ask("grand piano", seen)
    assert (answer["status"], answer["missing"]) == ("not_found", "grand piano")
    assert set(answer["nearest_miss"]) == {"id", "label", "p", "where"}
    assert "where" not in answer
    assert answer["said"].startswith("There is no grand piano; the nearest miss is the ")


def test_when_something_was_last_seen(seen):
    answer = ask("when did you last see the blue cup?", seen, k="1")
    assert (answer["status"], answer["form"]) == ("found", "when")
    (last,) = answer["last_seen"]
    assert (last["id"], last["state"], last["age_s"]) == (BLUE_CUP, "confirmed", 10.0)
    assert answer["said"].startswith("The blue cup was last seen 10 s ago, on the kitchen counter")


def test_what_is_gone_is_remembered():
    scene = emptied(RED_CUP)
    answer = ask("when did you last see the red cup?", scene, k="1")
    (last,) = answer["last_seen"]
    assert (last["id"], last["state"], last["age_s"]) == (RED_CUP, "removed", 20.0)
    assert answer["said"].endswith("it is gone since 0 s.")
    where = ask("where is the red cup", scene)
    assert where["status"] != "found"
    assert where["gone"]["id"] == RED_CUP
    assert "The red cup was last seen 20 s ago and is gone" in where["said"]
    assert RED_CUP not in [one["id"] for one in where["instances"]]


def test_what_never_was_is_not_remembered():
    answer = ask("when did you last see the bicycle", emptied(RED_CUP))
    assert answer["status"] == "not_found"
    assert answer["said"] == "No bicycle was ever seen, as far as this map remembers."


def test_what_comes_back_is_not_gone_and_another_map_knows_no_past():
    scene = emptied(RED_CUP)
    assert [one.geometry.instance_id for one in scene.snapshot().past] == [RED_CUP]
    back = [one for one in built() if one.instance_id == RED_CUP]
    scene.apply_map(Revision(5, 15, 113, 80 * SECOND_NS), back, UP, full=False)
    assert scene.snapshot().past == ()
    other = emptied(RED_CUP)
    other.apply_map(Revision(6, 1, 0, 0), [], UP, full=True)
    assert other.snapshot().past == ()


def test_what_was_merged_is_not_gone():
    scene = room()
    merged = replace(built()[RED_CUP - 1], state="removed", merged_into=BLUE_CUP)
    scene.apply_map(Revision(5, 14, 112, 70 * SECOND_NS), [merged], UP, full=False)
    assert scene.snapshot().past == ()


def test_several_things_get_a_ranking_each(seen):
    answer = ask("the blue cup and the lamp", seen, k="2")
    assert answer["status"] == "found"
    assert [one["question"] for one in answer["targets"]] == ["the blue cup", "the lamp"]
    assert [one["instances"][0]["id"] for one in answer["targets"]] == [BLUE_CUP, 16]
    assert [len(one["instances"]) for one in answer["targets"]] == [2, 2]
    assert [one["id"] for one in answer["instances"]] == [BLUE_CUP, 16]
    assert answer["said"].count(".") >= 2
    mixed = ask("the blue cup and the bathtub", seen)
    assert mixed["status"] == "ambiguous"
    assert [one["status"] for one in mixed["targets"]] == ["found", "not_found"]


@pytest.mark.parametrize(
    ("text", "best"),
    [
        ("the cup that is not red", BLUE_CUP),
        ("the second closest chair to the dining table", 12),
        ("the chair closest to the dining table", 11),
        ("the leftmost chair", 13),
        ("the box between the chair and the lamp", 14),
        ("the couch with a pillow on it", 3),
    ],
)
def test_relations_and_attributes(seen, text, best):
    answer = ask(text, seen)
    assert answer["instances"][0]["id"] == best
    assert answer["form"] == "find"


def test_an_empty_map_answers_every_form():
    scene = furnish(())
    for text in ("cup", "where is the cup", "how many cups", "what is on the table",
                 "is there a cup", "when did you last see the cup"):  # fmt: skip
        answer = ask(text, scene)
        assert answer["status"] == "not_found"
        assert answer["said"]


def test_the_schema_knows_every_form():
    assert FORMS == forms.FORMS


class Seeing:
    """Sees the words that a test holds up."""

    def __init__(self, words):
        self.vector = WordEncoder().encode_texts([words])[0]

    def __call__(self, rgb):
        assert rgb.dtype == np.uint8
        return self.vector


def show(picture, seeing, **given):
    request = Request(QUERY_INSTANCES, "", {}, False, given, picture, "")
    answer = json.loads(door(room(), seeing=seeing).instances(request).payload)
    jsonschema.validate(answer, ANSWER)
    return answer


def encoded(ending, size=(40, 30)):
    rgb = np.full((*size[::-1], 3), 90, np.uint8)
    return cv2.imencode(ending, rgb)[1].tobytes()


@pytest.mark.parametrize("ending", [".jpg", ".png"])
def test_a_picture_is_a_question(ending):
    answer = show(encoded(ending), Seeing("lamp"), k="2")
    assert (answer["form"], answer["question"]) == ("picture", "picture of 40 x 30 pixels")
    assert answer["instances"][0]["id"] == 16
    assert len(answer["instances"]) == 2
    assert answer["status"] == "found"
    assert "image" in answer["cost"]["ms"]
    assert answer["said"].startswith("Most like the picture, with p ")


def test_a_picture_of_something_else_is_not_found():
    answer = show(encoded(".jpg"), Seeing("rhinoceros"))
    assert answer["status"] != "found"


@pytest.mark.parametrize(
    ("picture", "code"),
    [
        (encoded(".jpg")[:-20], "bad_request"),
        (encoded(".png")[:60], "bad_request"),
        (encoded(".png", (4, 4)), "bad_request"),
    ],
)
def test_a_broken_picture_is_refused(picture, code):
    with pytest.raises(QueryError) as refused:
        show(picture, Seeing("lamp"))
    assert refused.value.code == code


def test_an_encoder_without_eyes_says_so():
    request = Request(QUERY_INSTANCES, "", {}, False, {}, encoded(".jpg"), "")
    with pytest.raises(QueryError, match="sees no pictures") as refused:
        door(room()).instances(request)
    assert refused.value.code == "unavailable"


def named(payload=b"", encoding="", scene=None, given=None, **parameters):
    request = Request(QUERY_LABEL, "", {}, False, parameters, payload, encoding)
    return json.loads(door(scene or room(), **(given or {})).label(request).payload)


def test_any_labels_may_be_given(seen):
    answer = named(id="16", labels="mug, lamp,bicycle", scene=seen)
    assert answer["labels"][0]["label"] == "lamp"
    assert {one["label"] for one in answer["labels"]} == {"mug", "lamp", "bicycle"}
    assert sum(one["p"] for one in answer["labels"]) == pytest.approx(1.0, abs=1e-3)
    assert answer["status"] == "found"


@pytest.mark.parametrize(
    ("payload", "encoding"),
    [
        (b"mug,lamp", ""),
        (b'{"labels": ["mug", "lamp", "mug"], "id": 16}', "application/json"),
    ],
)
def test_labels_may_come_as_payload(seen, payload, encoding):
    answer = named(payload, encoding, id="16", scene=seen)
    assert [one["label"] for one in answer["labels"]] == ["lamp", "mug"]


@pytest.mark.parametrize(
    "labels", [",".join(f"l{n}" for n in range(201)), "x" * 65, ["a", 1], {"a": 1}]
)
def test_labels_that_cannot_be_used(seen, labels):
    payload = json.dumps({"labels": labels}).encode()
    with pytest.raises(QueryError, match="labels") as refused:
        named(payload, "application/json", id="16", scene=seen)
    assert refused.value.code == "bad_request"


def test_a_reasoner_chooses_among_the_given_labels(seen):
    told = []

    def verdict(problem):
        return LabelVerdict(((problem.labels[-1][0], 1.0),), "it looks so", 1)

    given = {"name": verdict, "told": told.append}
    answer = named(id="16", labels="mug,lamp", mode="reason", scene=seen, given=given)
    assert (answer["route"], answer["labels"][0]["label"]) == ("reasoned", "mug")
    assert told == []
    named(id="16", mode="reason", scene=seen, given=given)
    assert [naming.instance.instance_id for naming in told] == [16]
