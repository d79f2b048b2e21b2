"""The front door: every queryable, with and without a question, and what a restart needs."""

import json
from dataclasses import replace

import msgpack
import numpy as np
import pytest

from sceneq_core.mapping.delta import Place
from sceneq_core.reasoning.geometric import GeometricParams, GeometricReasoner
from sceneq_core.reasoning.reasoner import LabelVerdict, Usage, Verdict
from sceneq_nodes._backends import BACKENDS
from sceneq_nodes._bus import QueryError, Reply
from sceneq_nodes._reason_json import (
    any_problem_from_bytes,
    problem_from_bytes,
    verdict_bytes,
)
from sceneq_nodes._wire import to_bytes
from sceneq_nodes.routing import Routing
from sceneq_schemas.feature import Descriptor, FeatureDelta
from sceneq_schemas.frame import Pose
from sceneq_schemas.topics import (
    FEATURE_DELTA,
    FEATURE_SNAPSHOT,
    MAP_DELTA,
    MAP_SNAPSHOT,
    POSE,
    QUERY_ASK,
    QUERY_INSTANCES,
    QUERY_LABEL,
    QUERY_LABELS,
    QUERY_LAST,
    QUERY_STATUS,
    REASON,
    VIEW_DELTA,
    VIEW_SNAPSHOT,
)
from sceneq_schemas.view import View, ViewDelta, ViewSet

from support.fake_bus import FakeBus
from support.furnished import ROOM, WordEncoder, instance
from support.furnished_node import map_delta_of

LABELS = (
    *{
        thing.name.split()[-1] if "cup" in thing.name or "couch" in thing.name else thing.name: 0
        for thing in ROOM
    },
    "bathtub",
)
PARAMS = Routing.Params(encoder={"kind": "words"}, labels=LABELS)
ENCODER = WordEncoder()
QUERIES = (QUERY_INSTANCES, QUERY_ASK, QUERY_LABEL, QUERY_STATUS, QUERY_LABELS, QUERY_LAST)
EPOCH = 5


def map_delta(seq=1, *, full=True, things=ROOM, **changes):
    return map_delta_of(things, EPOCH, seq, full=full, **changes)


def view_delta(seq=1, things=ROOM):
    box = np.array([1.0, 2.0, 30.04, 40.0], np.float32)
    sets = tuple(
        ViewSet(i + 1, (View(10 * (i + 1), 5, 99, box, (0, 0), b""),)) for i in range(len(things))
    )
    return ViewDelta(1, seq, True, 10, 1_000, EPOCH, 1, sets)


def feature_delta(seq=1, things=ROOM):
    vectors = ENCODER.encode_texts([thing.name for thing in things]) if things else ()
    none = np.zeros(0, np.float32)
    rows = tuple(
        Descriptor(i + 1, np.array([10], np.int64), row, none) for i, row in enumerate(vectors)
    )
    removed = np.zeros(0, np.int32)
    return FeatureDelta(1, seq, True, 10, 1_000, ENCODER.model_id, rows, removed, EPOCH)


def pose(position):
    T_world_camera = np.eye(4)
    T_world_camera[:3, 3] = position
    return Pose(seq=1, stamp_ns=1, T_world_camera=T_world_camera, source="given", keyframe=True)


@pytest.fixture(autouse=True)
def plug_in_the_word_encoder(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setitem(BACKENDS["encoder"], "words", "support.furnished:WordEncoder")


@pytest.fixture
def empty():
    bus = FakeBus()
    bus.node = Routing(PARAMS, bus.context)
    bus.node.open(bus)
    return bus


@pytest.fixture
def bus(empty):
    empty.deliver(empty.node, POSE, pose((0.0, -3.0, 1.5)))
    empty.deliver(empty.node, MAP_DELTA, map_delta())
    empty.deliver(empty.node, VIEW_DELTA, view_delta())
    empty.deliver(empty.node, FEATURE_DELTA, feature_delta(), model=ENCODER.model_id)
    return empty


def ask(bus, topic, q="", *, wildcard=False, **parameters):
    if q:
        parameters["q"] = q
    reply = bus.query(topic, parameters=parameters, wildcard=wildcard)
    return None if reply is None else json.loads(reply.payload)


def with_reasoner(bus):
    reasoner = GeometricReasoner(GeometricParams())

    def solve(request):
        verdict = reasoner.solve(problem_from_bytes(request.payload))
        return Reply(verdict_bytes(verdict), REASON.encoding)

    bus.answer(REASON, solve)


def test_an_answer_has_everything_a_client_needs(bus):
    answer = ask(bus, QUERY_INSTANCES, "where is the lamp?")
    assert list(answer) == [
        "status",
        "question",
        "form",
        "said",
        "where",
        "instances",
        "confidence",
        "route",
        "cached",
        "reason",
        "cost",
        "map",
        "calibration",
        "query_id",
        "took_ms",
    ]
    assert (answer["status"], answer["route"]) == ("found", "fast")
    assert answer["question"] == "where is the lamp?"
    assert len(answer["instances"]) == 5
    assert set(answer["confidence"]) == {
        *("p_max", "p_null", "margin", "entropy_norm", "T", "presence"),
    }
    assert answer["cost"]["vlm_calls"] == 0
    assert set(answer["cost"]["ms"]) == {"text", "search", "report"}
    assert (answer["map"]["epoch"], answer["map"]["seq"]) == (5, 1)
    assert 0 <= answer["map"]["age_s"] < 60


def test_an_instance_comes_with_boxes_and_evidence(bus):
    best = ask(bus, QUERY_INSTANCES, "lamp", k="1")["instances"][0]
    assert best["p"] > 0.9
    assert best["cosine"] == pytest.approx(1.0)
    del best["p"], best["cosine"], best["label_p"]
    assert best == {
        "id": 16,
        "label": "lamp",
        "label_source": "encoder",
        "role": "object",
        "centre": [-2.75, 2.15, 0.8],
        "box_aabb": {"min": [-2.9, 2.0, 0.0], "max": [-2.6, 2.3, 1.6]},
        "box_oriented": {
            "centre": [-2.75, 2.15, 0.8],
            "size": [0.3, 0.3, 1.6],
            "rotation": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        },
        "supported_by": None,
        "inside": None,
        "neighbours": [],
        "state": "confirmed",
        "state_since_ns": 0,
        "first_seen_ns": 1_000,
        "last_seen_ns": 9_000,
        "places": [],
        "views": [
            {
                "seq": 160,
                "box_xyxy": [1.0, 2.0, 30.0, 40.0],
                "key": "sceneq/view/room/@image/v1?seq=160",
            }
        ],
    }


def test_an_instance_comes_with_its_place_in_the_scene_graph(bus):
    things = tuple(instance(i + 1, thing) for i, thing in enumerate(ROOM))
    cup = replace(things[5], supported_by=5, inside=4, neighbour_id=np.array([9, 10], np.int32))
    told = (replace(things[0], role="floor"), *things[1:5], cup, *things[6:])
    bus.deliver(bus.node, MAP_DELTA, map_delta(2, instances=told))
    best = ask(bus, QUERY_INSTANCES, "red cup", k="1")["instances"][0]
    assert (best["supported_by"], best["inside"], best["neighbours"]) == (5, 4, [9, 10])
    floor = ask(bus, QUERY_INSTANCES, "where is the floor?")["instances"]
    assert [(one["id"], one["role"], one["label"]) for one in floor] == [(1, "floor", "floor")]


def test_what_is_tentative_is_not_answered_with_and_what_is_stale_says_so(bus):
    low, high = np.zeros(3), np.full(3, 0.5)
    place = Place(high / 2, np.stack((low, high)), from_ns=1_000, until_ns=4_000)
    things = [instance(i + 1, thing) for i, thing in enumerate(ROOM)]
    things[15] = replace(things[15], state="stale", state_since_ns=8_000, places=(place,))
    things[5] = replace(things[5], state="tentative")
    bus.deliver(bus.node, MAP_DELTA, map_delta(2, instances=tuple(things)))
    answer = ask(bus, QUERY_INSTANCES, "lamp", k="20")
    assert 6 not in [one["id"] for one in answer["instances"]]
    lamp = answer["instances"][0]
    assert (lamp["id"], lamp["state"], lamp["state_since_ns"]) == (16, "stale", 8_000)
    assert answer["reason"].endswith("; 16 was looked for there and not found, or in part")
    assert lamp["places"] == [
        {
            "centre": [0.25, 0.25, 0.25],
            "box_aabb": {"min": [0.0, 0.0, 0.0], "max": [0.5, 0.5, 0.5]},
            "from_ns": 1_000,
            "until_ns": 4_000,
        }
    ]


def test_the_payload_beats_the_parameter(bus):
    reply = bus.query(QUERY_INSTANCES, parameters={"q": "lamp"}, payload=b"chair")
    assert json.loads(reply.payload)["question"] == "chair"


def test_a_json_payload_is_a_request(bus):
    reply = bus.query(
        QUERY_INSTANCES, payload=b'{"q": "chair", "k": 2}', encoding="application/json"
    )
    answer = json.loads(reply.payload)
    assert len(answer["instances"]) == 2
    assert reply.encoding == "application/json;sceneq.answer.v1"


def test_a_msgpack_request_gets_a_msgpack_answer(bus):
    reply = bus.query(
        QUERY_INSTANCES, payload=msgpack.packb({"q": "chair"}), encoding="application/msgpack"
    )
    assert msgpack.unpackb(reply.payload)["question"] == "chair"
    assert reply.encoding == "application/msgpack;sceneq.answer.v1"
    assert msgpack.unpackb(bus.query(QUERY_STATUS, parameters={"fmt": "msgpack"}).payload)


@pytest.mark.parametrize(
    ("parameters", "payload", "encoding", "message"),
    [
        ({"q": "x" * 1001}, b"", "", "the limit is 1000"),
        ({"q": "?!"}, b"", "", "no words"),
        ({"q": "cup", "k": "many"}, b"", "", "k: expected a whole number"),
        ({"q": "cup", "k": "0"}, b"", "", "k: 0 is below 1"),
        ({"q": "cup", "k": "²"}, b"", "", "k: expected a whole number"),
        ({"q": "cup", "mode": "slow"}, b"", "", "mode: 'slow', known: fast, reason"),
        ({"q": "cup", "fmt": "xml"}, b"", "", "fmt: 'xml'"),
        ({}, b"\xff\xfe", "text/plain", "not valid text/plain"),
        ({}, b"[1]", "application/json", "expected an object"),
        ({}, b'{"q": 3}', "application/json", "q: expected a text"),
        ({}, b"\xc1", "application/msgpack", "not valid application/msgpack"),
        ({}, b"x" * 70_000, "", "the limit is 65536"),
    ],
)
def test_bad_requests_say_what_is_wrong(bus, parameters, payload, encoding, message):
    with pytest.raises(QueryError, match=message) as refused:
        bus.query(QUERY_INSTANCES, parameters=parameters, payload=payload, encoding=encoding)
    assert refused.value.code == "bad_request"
    assert refused.value.hint


@pytest.mark.parametrize("topic", QUERIES)
def test_a_wildcard_get_is_answered_shortly_from_memory(bus, topic):
    reply = bus.query(topic, wildcard=True)
    assert len(reply.payload) < 4096
    assert isinstance(json.loads(reply.payload), dict)


def test_the_overview_counts_and_explains(bus):
    overview = ask(bus, QUERY_INSTANCES, wildcard=True)
    assert overview["instances"] == overview["answerable"] == 16
    assert (overview["map"]["epoch"], overview["map"]["seq"]) == (5, 1)
    assert next(iter(overview["labels"].items())) == ("chair", 3)
    assert overview["usage"]["instances"].startswith("sceneq/query/room/instances?q=red mug")


def test_a_wildcard_question_is_answered_by_instances_only(bus):
    answered = [t.pattern for t in QUERIES if ask(bus, t, "lamp", wildcard=True) is not None]
    assert answered == [QUERY_INSTANCES.pattern]


def test_a_wildcard_question_in_mode_reason_reaches_ask(bus):
    assert ask(bus, QUERY_ASK, "lamp", wildcard=True, mode="reason")["status"] == "found"


def test_instances_are_listed_page_by_page(bus):
    first = ask(bus, QUERY_INSTANCES, k="10")
    rest = ask(bus, QUERY_INSTANCES, k="10", after=str(first["instances"][-1]["id"]))
    assert [one["id"] for one in first["instances"] + rest["instances"]] == list(range(1, 17))
    assert first["count"] == 16
    assert first["instances"][15 - 6]["label"]


def test_one_instance_by_id(bus):
    assert [one["id"] for one in ask(bus, QUERY_INSTANCES, id="7")["instances"]] == [7]
    with pytest.raises(QueryError, match="no such instance: 99") as missing:
        ask(bus, QUERY_INSTANCES, id="99")
    assert missing.value.code == "not_found"


def test_instances_without_descriptor_are_listed_without_a_name(bus):
    bus.deliver(bus.node, MAP_DELTA, map_delta(2, full=False, instances=(instance(17, ROOM[0]),)))
    listed = ask(bus, QUERY_INSTANCES, k="5", after="15")
    assert [(one["id"], one["label"]) for one in listed["instances"]] == [(16, "lamp"), (17, None)]
    assert listed["count"] == 17
    assert listed["instances"][1]["views"] == []
    overview = ask(bus, QUERY_INSTANCES)
    assert (overview["instances"], overview["answerable"]) == (17, 16)
    with pytest.raises(QueryError, match="no such instance: 17"):
        ask(bus, QUERY_LABEL, id="17")


def test_label_names_an_instance(bus):
    naming = ask(bus, QUERY_LABEL, id="16")
    assert naming["status"] == "found"
    assert naming["labels"][0]["label"] == "lamp"
    assert len(naming["labels"]) == 5
    assert naming["instance"]["id"] == 16


def test_labels_and_status(bus):
    assert ask(bus, QUERY_LABELS)["labels"] == list(LABELS)
    status = ask(bus, QUERY_STATUS)
    assert status["synced"] == {"map_delta": True, "view_delta": True, "feature_delta": True}
    assert status["alive"] == ["test"]
    assert (status["robot"], status["sensor"]) == ("r1", "cam")
    assert bus.reported["answerable"] == 16


def test_last_answers_are_kept_newest_first_and_bounded(bus):
    for number in range(20):
        ask(bus, QUERY_INSTANCES, f"lamp number {number}")
    answers = ask(bus, QUERY_LAST)["answers"]
    assert len(answers) == 16
    assert answers[0]["question"] == "lamp number 19"
    assert len(json.dumps(answers)) < 4096


def test_the_last_few_answers_are_told_as_they_were_given(bus):
    given = [ask(bus, QUERY_INSTANCES, f"lamp number {number}") for number in range(5)]
    told = ask(bus, QUERY_LAST, k="2")["answers"]
    assert told == given[:-3:-1]
    assert len(ask(bus, QUERY_LAST, k="9")["answers"]) == 3


def test_a_relation_is_reasoned(bus):
    with_reasoner(bus)
    answer = ask(bus, QUERY_ASK, "cup on the couch")
    assert answer["route"] == "reasoned"
    assert answer["reason"] == "none of the candidates for 'cup' is on 'couch'"
    pillow = ask(bus, QUERY_ASK, "pillow on the couch")
    assert (pillow["status"], pillow["instances"][0]["id"]) == ("found", 4)
    assert "reason" in pillow["cost"]["ms"]


def test_a_sure_answer_needs_no_reasoner_unless_told(bus):
    with_reasoner(bus)
    assert ask(bus, QUERY_ASK, "lamp")["route"] == "fast"
    assert not bus_asked(bus)
    assert ask(bus, QUERY_ASK, "lamp", mode="reason")["route"] == "reasoned"
    assert ask(bus, QUERY_ASK, "pillow on the couch", mode="fast")["route"] == "fast"


def bus_asked(bus):
    return [request for request in bus.asked if request.topic is REASON]


def test_left_and_right_are_seen_from_the_camera(bus):
    with_reasoner(bus)
    assert ask(bus, QUERY_ASK, "lamp to the left of the couch")["status"] == "found"
    bus.deliver(bus.node, POSE, pose((-1.5, 9.0, 1.5)))
    assert ask(bus, QUERY_ASK, "lamp to the left of the couch")["status"] == "not_found"


def raise_timeout(_):
    raise QueryError("timeout", "no reply in time")


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        (lambda _: None, "no reasoner answered"),
        (raise_timeout, "the reasoner failed: timeout: no reply in time"),
        (lambda _: Reply(b"{", ""), "the reasoner failed: not JSON"),
        (
            lambda _: Reply(verdict_bytes(Verdict(((99, 1.0),), "!", 1)), ""),
            "verdict: instance 99 was not a candidate",
        ),
    ],
)
def test_without_a_verdict_the_encoder_answers(bus, answer, reason):
    bus.answer(REASON, answer)
    told = ask(bus, QUERY_ASK, "pillow on the couch")
    assert told["route"] == "fallback"
    assert told["reason"].startswith(reason)
    assert told["instances"][0]["id"] == 4


def test_a_name_may_be_reasoned(bus):
    def name(request):
        labels = any_problem_from_bytes(request.payload).labels
        ranking = ((labels[1][0], 0.9), (labels[0][0], 0.1))
        return Reply(verdict_bytes(LabelVerdict(ranking, "seen twice", 2, Usage(7, 8, 0.5))), "")

    bus.answer(REASON, name)
    fast = ask(bus, QUERY_LABEL, id="4")
    told = ask(bus, QUERY_LABEL, id="4", mode="reason")
    assert told["labels"][0] == fast["labels"][1] | {"p": 0.9, "source": "reasoner"}
    assert (told["route"], told["reason"]) == ("reasoned", "seen twice")
    assert told["cost"]["vlm_calls"] == 2
    assert told["cost"]["tokens"] == {"in": 7, "out": 8}
    assert told["cost"]["money"] == 0.5


@pytest.mark.parametrize("ranking", [(), (("unicorn", 1.0),)])
def test_a_name_that_was_not_proposed_is_not_taken_over(bus, ranking):
    bus.answer(REASON, lambda _: Reply(verdict_bytes(LabelVerdict(ranking, "!", 1)), ""))
    told = ask(bus, QUERY_LABEL, id="4", mode="reason")
    assert told["route"] == "fallback"
    assert told["reason"].startswith("verdict: ")
    assert told["labels"] == ask(bus, QUERY_LABEL, id="4")["labels"]


def test_an_empty_map_answers_well_formed(empty):
    for topic in (QUERY_INSTANCES, QUERY_ASK):
        answer = ask(empty, topic, "cup")
        assert (answer["status"], answer["instances"]) == ("not_found", [])
        assert answer["reason"].startswith("the map is empty")
        assert answer["map"]["age_s"] is None


def test_changes_show_in_the_next_answer(bus):
    gone = (instance(16, ROOM[15], state="removed"),)
    bus.deliver(bus.node, MAP_DELTA, map_delta(2, full=False, instances=gone))
    assert ask(bus, QUERY_INSTANCES, "lamp")["status"] == "not_found"
    assert ask(bus, QUERY_INSTANCES, wildcard=True)["instances"] == 15


def test_impossible_numbers_are_left_out_and_counted(bus):
    broken = replace(instance(16, ROOM[15]), centre_world=np.array([np.nan, 0.0, 0.0]))
    bus.deliver(bus.node, MAP_DELTA, map_delta(2, instances=(broken, instance(1, ROOM[0]))))
    short = replace(feature_delta(2).descriptors[0], descriptor=np.zeros(3, np.float32))
    wrong = replace(feature_delta(2), full=False, descriptors=(short,))
    bus.deliver(bus.node, FEATURE_DELTA, wrong, model=ENCODER.model_id)
    bus.deliver(bus.node, POSE, pose((np.inf, 0.0, 0.0)))
    assert bus.counters["instances_refused"] == 1
    assert bus.counters["descriptors_refused"] == 1
    assert bus.counters["poses_refused"] == 1
    assert [one["id"] for one in ask(bus, QUERY_INSTANCES, k="9")["instances"]] == [1]


def test_a_restarted_node_catches_up_from_snapshots():
    bus = FakeBus()
    for topic, message in (
        (MAP_SNAPSHOT, map_delta(7)),
        (VIEW_SNAPSHOT, view_delta(7)),
        (FEATURE_SNAPSHOT, feature_delta(7)),
    ):
        reply = Reply(to_bytes(topic, message), topic.encoding)
        bus.answer(topic, lambda _, reply=reply: reply, model=ENCODER.model_id)
    Routing(PARAMS, bus.context).open(bus)
    answer = ask(bus, QUERY_INSTANCES, "lamp")
    assert (answer["status"], answer["map"]["seq"]) == ("found", 7)


def answerable(bus):
    return ask(bus, QUERY_INSTANCES, wildcard=True)["answerable"]


def test_a_restart_of_encoding_or_views_takes_no_answer_away(bus):
    for topic, empty, some in (
        (FEATURE_DELTA, feature_delta(1, ()), feature_delta(2, ROOM[:2])),
        (VIEW_DELTA, view_delta(1, ()), view_delta(2, ROOM[:2])),
    ):
        ids = {"model": ENCODER.model_id} if topic is FEATURE_DELTA else {}
        for message in (empty, some):
            bus.deliver(bus.node, topic, replace(message, epoch=2), **ids)
            assert answerable(bus) == len(ROOM)
    assert ask(bus, QUERY_INSTANCES, "lamp")["status"] == "found"


@pytest.mark.parametrize("late", [VIEW_DELTA, FEATURE_DELTA])
def test_a_restarted_writer_that_knows_no_map_takes_no_answer_away(bus, late):
    message = view_delta(1, ()) if late is VIEW_DELTA else feature_delta(1, ())
    ids = {"model": ENCODER.model_id} if late is FEATURE_DELTA else {}
    bus.deliver(bus.node, late, replace(message, epoch=2, map_epoch=0), **ids)
    assert answerable(bus) == len(ROOM)


def test_after_a_restart_of_the_map_no_answer_mixes_the_old_and_the_new(bus):
    """Instance 1 is the lamp now; it was a chair."""
    model, lamp = {"model": ENCODER.model_id}, ROOM[15:]
    bus.deliver(bus.node, MAP_DELTA, replace(map_delta(1, things=lamp), epoch=EPOCH + 1))
    assert answerable(bus) == 0
    moved = replace(view_delta(2, lamp), map_epoch=EPOCH + 1)
    bus.deliver(bus.node, VIEW_DELTA, moved)
    assert answerable(bus) == 0
    of_the_old_map = replace(feature_delta(2, ROOM[:1]), full=False)
    bus.deliver(bus.node, FEATURE_DELTA, of_the_old_map, **model)
    assert answerable(bus) == 0
    bus.deliver(
        bus.node, FEATURE_DELTA, replace(feature_delta(3, lamp), map_epoch=EPOCH + 1), **model
    )
    assert answerable(bus) == 1
    answer = ask(bus, QUERY_INSTANCES, "lamp")
    assert [(one["id"], one["label"]) for one in answer["instances"]] == [(1, "lamp")]


def test_stop_without_a_message():
    bus = FakeBus()
    node = Routing(PARAMS, bus.context)
    node.open(bus)
    node.step(None)
    node.close()
    assert bus.published == []


def test_bad_parameters_are_refused():
    with pytest.raises(ValueError, match="reason_timeout_s"):
        Routing.Params(reason_timeout_s=0)
    bus = FakeBus()
    with pytest.raises(ValueError, match="unknown 'coco'"):
        Routing(Routing.Params(encoder={"kind": "words"}, label_set="coco"), bus.context).open(bus)


def test_a_stream_of_poses_does_not_keep_it_from_catching_up(monkeypatch):
    bus = FakeBus()
    node = Routing(PARAMS, bus.context)
    node.open(bus)
    monkeypatch.setattr("sceneq_nodes._follow.RETRY_S", 0.0)
    for follower in node._followers.values():
        follower._next_ask = 0.0
    asked = len(bus.asked)
    bus.deliver(node, POSE, pose((0.0, 0.0, 0.0)))
    assert len(bus.asked) == asked + 3
