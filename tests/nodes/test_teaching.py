"""Names over the bus: given, asked for, listed, taken back, and there again after a restart."""

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.mapping.delta import Event
from sceneq_core.routing import judge
from sceneq_core.routing.router import RouterParams
from sceneq_nodes._backends import BACKENDS
from sceneq_nodes._bus import QueryError
from sceneq_nodes.routing import Routing
from sceneq_schemas.feature import Descriptor, FeatureDelta
from sceneq_schemas.topics import (
    FEATURE_DELTA,
    MAP_DELTA,
    QUERY_INSTANCES,
    QUERY_LABEL,
    QUERY_NAMES,
    QUERY_STATUS,
    TEACH_FORGET,
    TEACH_SET,
    VIEW_DELTA,
)
from sceneq_schemas.view import View, ViewDelta, ViewSet

from support.fake_bus import CONTEXT, FakeBus
from support.furnished import ROOM, WordEncoder, instance
from support.furnished_node import map_delta_of

LIKENESS = {
    "format": "sceneq.likeness.v1",
    "encoders": {
        "words": {
            "alike": {"weights": [20.0], "bias": -14.0},
            "again": {"weights": [30.0, 6.0], "bias": -11.0},
        }
    },
}
LABELS = tuple(dict.fromkeys(thing.name.split()[-1] for thing in ROOM))
ENCODER = WordEncoder()
MUG = "aunt Mary's mug"
RED_CUP, BLUE_CUP, CHAIR = 6, 7, 11


def map_delta(epoch, seq=1, things=ROOM, instances=None, full=True):
    told = {"instances": instances} if instances else {}
    events = (Event("merged", 2, 3, 1_000),)
    return map_delta_of(things, epoch, seq, full=full, events=events, **told)


def view_delta(epoch, things=ROOM):
    def box(i):
        return np.array([10.0 * i, 0.0, 10.0 * i + 30.0, 40.0 + i], np.float32)

    sets = tuple(
        ViewSet(i + 1, (View(120, 5, 99, box(i), (0, 0), b""),)) for i in range(len(things))
    )
    return ViewDelta(epoch, 1, True, 10, 1_000, epoch, 1, sets)


def feature_delta(epoch, things=ROOM):
    vectors = ENCODER.encode_texts([thing.name for thing in things])
    none = np.zeros(0, np.float32)
    rows = tuple(
        Descriptor(i + 1, np.array([10], np.int64), row, none) for i, row in enumerate(vectors)
    )
    return FeatureDelta(
        epoch, 1, True, 10, 1_000, ENCODER.model_id, rows, np.zeros(0, np.int32), epoch
    )


def see(bus, epoch=5, things=ROOM):
    """Let the graph have mapped the room."""
    bus.deliver(bus.node, MAP_DELTA, map_delta(epoch, things=things))
    bus.deliver(bus.node, VIEW_DELTA, view_delta(epoch, things))
    bus.deliver(bus.node, FEATURE_DELTA, feature_delta(epoch, things), model=ENCODER.model_id)


@pytest.fixture(autouse=True)
def _word_encoder(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setitem(BACKENDS["encoder"], "words", "support.furnished:WordEncoder")


@pytest.fixture
def start(tmp_path):
    """Start the node again and again on one store."""
    likeness = tmp_path / "likeness.json"
    likeness.write_text(json.dumps(LIKENESS))
    params = Routing.Params(
        encoder={"kind": "words"},
        labels=LABELS,
        likeness=str(likeness),
        router=RouterParams(judge=judge.JudgeParams()),
    )

    def started(store=True):
        (tmp_path / "room").mkdir(exist_ok=True)
        bus = FakeBus(replace(CONTEXT, store=tmp_path / "room" if store else None))
        bus.node = Routing(params, bus.context)
        bus.node.open(bus)
        return bus

    return started


@pytest.fixture
def bus(start):
    bus = start()
    see(bus)
    return bus


def ask(bus, topic, *, wildcard=False, payload=b"", encoding="", **parameters):
    reply = bus.query(
        *(topic,),
        parameters={key: str(value) for key, value in parameters.items()},
        payload=payload,
        encoding=encoding,
        wildcard=wildcard,
    )
    return None if reply is None else json.loads(reply.payload)


def answer(bus, text):
    """Return an answer without what differs from one to the next."""
    told = ask(bus, QUERY_INSTANCES, q=text)
    for varying in ("query_id", "took_ms", "map"):
        del told[varying]
    return {**told, "cost": {**told["cost"], "ms": None}}


def teach(bus, name=MUG, **parameters):
    if not parameters.keys() & {"id", "view"}:
        parameters["id"] = RED_CUP
    return ask(bus, TEACH_SET, name=name, **parameters)


def refused(bus, topic, **parameters):
    with pytest.raises(QueryError) as error:
        ask(bus, topic, **parameters)
    return error.value


def test_a_taught_name_is_found_at_once_and_the_reason_says_who_taught_it(bus):
    told = teach(bus, by="anna")
    assert (told["status"], told["id"], told["kind"]) == ("taught", RED_CUP, "individual")
    assert (told["state"], told["p"], told["kept"]) == ("attached", 0.99, True)
    found = answer(bus, "Where is Aunt Mary’s mug?")
    best = found["instances"][0]
    assert (found["status"], found["route"], best["id"]) == ("found", "fast", RED_CUP)
    assert best["p"] == pytest.approx(0.99, abs=0.01)
    assert (best["label"], best["label_source"]) == (MUG, "taught")
    assert found["reason"] == f"'{MUG}' was taught by anna on {told['when']}"
    assert found["said"].startswith(f"Aunt Mary's mug ({RED_CUP}) is ")


def test_what_it_was_called_before_still_finds_it(bus):
    before = answer(bus, "red cup")
    teach(bus)
    after = answer(bus, "red cup")
    assert [one["id"] for one in after["instances"]] == [one["id"] for one in before["instances"]]
    assert (after["status"], after["confidence"]) == (before["status"], before["confidence"])


@pytest.mark.parametrize("text", ["aunt Mary's mug", "the red cup", "what is near the lamp?"])
def test_taking_a_name_back_restores_every_answer(bus, text):
    before = answer(bus, text)
    teach(bus)
    told = ask(bus, TEACH_FORGET, name="AUNT MARY'S MUG")
    assert [one["name"] for one in told["names"]] == [MUG]
    assert answer(bus, text) == before


def test_a_name_may_be_an_anchor(bus):
    teach(bus, "Bertha", id=16)
    near = answer(bus, "what is next to Bertha?")
    assert near["instances"][0]["id"] != 16
    beside = answer(bus, "the couch next to Bertha")
    assert (beside["instances"][0]["id"], beside["status"]) == (3, "ambiguous")


def test_a_name_counts(bus):
    teach(bus, "windsor", id=CHAIR)
    assert answer(bus, "how many windsors are there?")["count"]["sure"] == 3
    teach(bus, MUG)
    assert answer(bus, f"is there {MUG}?")["exists"] == "yes"


def test_look_alikes_inherit_and_who_they_are_is_told(bus):
    told = teach(bus, "windsor", id=CHAIR)
    assert [one["id"] for one in told["inherited"]] == [12, 13]
    found = answer(bus, "windsor")
    assert found["status"] == "ambiguous"
    assert [one["id"] for one in found["instances"][:3]] == [11, 12, 13]
    assert [one["label_source"] for one in found["instances"][:3]] == [
        *("taught", "inherited", "inherited")
    ]
    naming = ask(bus, QUERY_LABEL, id=12)
    assert naming["labels"][0]["label"] == "windsor"
    assert naming["reason"].startswith("it looks like what was taught to be 'windsor'")


def test_a_look_alike_of_an_individual_is_like_it_and_called_as_before(bus):
    teach(bus, "Anna's chair", id=CHAIR)
    labels = ask(bus, QUERY_LABEL, id=12)["labels"]
    assert "like Anna's chair" in [one["label"] for one in labels]
    assert answer(bus, "chair")["instances"][1]["label"] == "chair"
    assert answer(bus, "Anna's chair")["instances"][0]["id"] == CHAIR


def test_other_labels_are_chosen_among_without_what_was_taught(bus):
    teach(bus)
    labels = ask(bus, QUERY_LABEL, id=RED_CUP, labels="cup,lamp")["labels"]
    assert {one["label"] for one in labels} == {"cup", "lamp"}
    assert ask(bus, QUERY_LABEL, id=RED_CUP)["labels"][0]["label"] == MUG


def test_the_payload_may_be_the_name_or_an_object(bus):
    assert ask(bus, TEACH_SET, payload=MUG.encode(), id=RED_CUP)["name"] == MUG
    body = json.dumps({"id": BLUE_CUP, "name": "the jug", "kind": "individual", "by": "vlm"})
    told = ask(bus, TEACH_SET, payload=body.encode(), encoding="application/json")
    assert (told["name"], told["kind"], told["by"]) == ("jug", "individual", "vlm")


def test_a_place_in_a_picture_is_as_good_as_an_id(bus):
    told = teach(bus, view=120, x=65, y=20)
    assert told["id"] == 5
    assert told["pointed_at"] == [5, 6, 7]
    assert teach(bus, view=120, box="50,0,80,45")["id"] == RED_CUP
    assert refused(bus, TEACH_SET, name=MUG, view=121, x=65, y=20).code == "not_found"
    assert refused(bus, TEACH_SET, name=MUG, view=120, x=65, y=400).code == "not_found"


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({}, "name: no letter or digit in ''"),
        ({"name": MUG}, "say which instance"),
        ({"name": MUG, "id": 6, "view": 120}, "say which instance"),
        ({"name": MUG, "view": 120}, "view: say where in it"),
        ({"name": MUG, "view": 120, "x": 5}, "y: expected a number, got None"),
        ({"name": MUG, "view": 120, "x": "nan", "y": 1}, "x: expected a number"),
        ({"name": MUG, "view": 120, "box": "1,2,3"}, "box: expected four numbers"),
        ({"name": MUG, "view": 120, "box": "9,2,3,4"}, "box: expected left,top,right,bottom"),
        ({"name": MUG, "id": "x"}, "id: expected a whole number"),
        ({"name": "x" * 65, "id": 6}, "65 characters, the limit is 64"),
        ({"name": "a\nb", "id": 6}, "control characters"),
        ({"name": "cup by the door", "id": 6}, "reads as a relation"),
        ({"name": MUG, "id": 6, "kind": "thing"}, "kind: 'thing', known: individual, category"),
        ({"name": MUG, "id": 6, "by": "\x1b[31m"}, "by: control characters"),
    ],
)
def test_a_bad_request_says_what_is_wrong_and_changes_nothing(bus, wrong, message):
    error = refused(bus, TEACH_SET, **wrong)
    assert error.code == "bad_request"
    assert message in error.message
    assert ask(bus, QUERY_NAMES)["names"] == []


def test_what_is_not_there_cannot_be_taught(bus):
    assert refused(bus, TEACH_SET, name=MUG, id=99).code == "not_found"
    things = tuple(instance(i + 1, thing) for i, thing in enumerate(ROOM))
    young = (*things[:5], replace(things[5], state="tentative"), *things[6:])
    bus.deliver(bus.node, MAP_DELTA, map_delta(5, 2, instances=young))
    error = refused(bus, TEACH_SET, name=MUG, id=RED_CUP)
    assert (error.code, error.retry_ms) == ("not_ready", 1000)


def test_what_was_not_taught_cannot_be_forgotten(bus):
    assert refused(bus, TEACH_FORGET, name=MUG).code == "not_found"
    assert refused(bus, TEACH_FORGET, id=RED_CUP).code == "not_found"
    assert refused(bus, TEACH_FORGET).code == "bad_request"


def test_a_wildcard_changes_nothing(bus):
    assert ask(bus, TEACH_SET, wildcard=True, id=RED_CUP, name=MUG) is None
    teach(bus)
    assert ask(bus, TEACH_FORGET, wildcard=True, name=MUG) is None
    assert len(ask(bus, QUERY_NAMES, wildcard=True)["names"]) == 1
    assert ask(bus, QUERY_NAMES, wildcard=True, q="red cup") is None


def test_all_names_of_an_instance_can_be_taken_back(bus):
    teach(bus)
    teach(bus, "favourite", id=RED_CUP)
    teach(bus, "favourite", id=BLUE_CUP)
    told = ask(bus, TEACH_FORGET, id=RED_CUP, name="favourite")
    assert [(one["name"], one["id"]) for one in told["names"]] == [("favourite", RED_CUP)]
    told = ask(bus, TEACH_FORGET, id=RED_CUP)
    assert [one["name"] for one in told["names"]] == [MUG]
    assert [one["id"] for one in ask(bus, QUERY_NAMES)["names"]] == [BLUE_CUP]


def test_teaching_the_same_again_changes_nothing(bus):
    first = teach(bus, by="anna")
    assert teach(bus, by="anna")["stamp_ns"] == first["stamp_ns"]
    assert len((bus.context.store / "names.jsonl").read_bytes().splitlines()) == 1
    again = teach(bus, by="bert")
    assert [one["by"] for one in again["replaced"]] == ["anna"]
    assert [one["by"] for one in ask(bus, QUERY_NAMES)["names"]] == ["bert"]


def test_names_are_there_again_after_a_restart(bus, start):
    before = teach(bus, by="anna")
    see(again := start())
    (told,) = ask(again, QUERY_NAMES)["names"]
    assert told == {key: before[key] for key in told}
    assert answer(again, MUG) == answer(bus, MUG)


def test_a_new_map_with_other_ids_keeps_the_name(bus, start):
    teach(bus)
    see(bus, epoch=6, things=ROOM[::-1])
    (told,) = ask(bus, QUERY_NAMES)["names"]
    assert (told["id"], told["state"]) == (len(ROOM) + 1 - RED_CUP, "attached")
    see(again := start(), epoch=6, things=ROOM[::-1])
    assert ask(again, QUERY_NAMES)["names"] == [told]


def test_a_name_whose_thing_is_gone_is_listed_as_unattached(bus):
    teach(bus)
    see(bus, epoch=6, things=ROOM[:5])
    (told,) = ask(bus, QUERY_NAMES)["names"]
    assert (told["state"], told["id"], told["p"]) == ("unattached", None, 0.0)
    assert ask(bus, QUERY_STATUS)["names"] == {"taught": 1, "unattached": 1}
    found = answer(bus, MUG)
    assert found["reason"].endswith("but nothing in this map is that now")


def test_a_name_follows_a_merge(bus):
    teach(bus)
    gone = replace(instance(RED_CUP, ROOM[RED_CUP - 1], state="removed"), merged_into=BLUE_CUP)
    bus.deliver(bus.node, MAP_DELTA, map_delta(5, 2, instances=(gone,), full=False))
    assert ask(bus, QUERY_NAMES)["names"][0]["id"] == BLUE_CUP
    assert answer(bus, MUG)["instances"][0]["id"] == BLUE_CUP


def test_a_forgotten_name_is_forgotten_after_a_restart(bus, start):
    teach(bus)
    ask(bus, TEACH_FORGET, name=MUG)
    assert ask(start(), QUERY_NAMES)["names"] == []


def test_without_a_store_names_are_in_memory_only_and_that_is_said(start):
    bus = start(store=False)
    see(bus)
    assert teach(bus)["kept"] is False
    assert ask(bus, QUERY_NAMES)["kept"] is False
    assert ask(start(store=False), QUERY_NAMES)["names"] == []


def test_a_torn_line_is_set_aside_and_said_and_the_others_stay(bus, start):
    teach(bus)
    teach(bus, "Bertha", id=16)
    path = bus.context.store / "names.jsonl"
    whole = path.read_bytes()
    path.write_bytes(whole[:-50])
    again = start()
    told = ask(again, QUERY_NAMES)
    assert [one["name"] for one in told["names"]] == [MUG]
    assert told["problem"].startswith("1 damaged lines (line 2: it ends in the middle) set aside")
    assert again.counters["names_damaged"] == 1
    assert path.with_name("names.jsonl.corrupt").read_bytes() == whole[:-50]
    assert path.read_bytes() == whole.splitlines(keepends=True)[0]
    see(again)
    teach(again, "Bertha", id=16)
    assert "problem" not in ask(start(), QUERY_NAMES)


def test_what_cannot_be_written_is_not_taught(bus, monkeypatch):
    before = answer(bus, MUG)

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("sceneq_nodes._name_store.os.write", full)
    error = refused(bus, TEACH_SET, name=MUG, id=RED_CUP)
    assert (error.code, error.message) == (
        "not_kept",
        "the name cannot be written: No space left on device",
    )
    assert ask(bus, QUERY_NAMES)["names"] == []
    assert answer(bus, MUG) == before


def test_a_file_that_cannot_be_read_is_left_alone_and_said(start, tmp_path):
    (tmp_path / "room" / "names.jsonl").mkdir(parents=True)
    bus = start()
    see(bus)
    told = teach(bus)
    assert told["kept"] is False
    assert told["problem"].startswith("the names on disk cannot be used: ")
    assert bus.counters["names_damaged"] == 1


def test_names_are_taught_from_many_threads_while_the_map_changes(bus, start):
    names = [f"thing {n}" for n in range(40)]

    def say(number):
        return teach(bus, names[number], id=1 + number % len(ROOM))["name"]

    with ThreadPoolExecutor(4) as pool:
        said = pool.map(say, range(len(names)))
        for seq in range(2, 12):
            bus.deliver(bus.node, MAP_DELTA, map_delta(5, seq))
        assert list(said) == names
    told = ask(bus, QUERY_NAMES)["names"]
    assert {one["name"] for one in told} == set(names)
    assert {one["state"] for one in told} == {"attached"}
    see(again := start())
    assert {one["name"] for one in ask(again, QUERY_NAMES)["names"]} == set(names)
