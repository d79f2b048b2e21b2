"""Questions against a furnished room."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.reasoning.reasoner import Verdict
from sceneq_core.routing.judge import JudgeParams
from sceneq_core.routing.labels import Labeller, named
from sceneq_core.routing.revision import Revision
from sceneq_core.routing.router import Router, RouterParams

from support.furnished import (
    ROOM,
    Thing,
    WordEncoder,
    descriptors,
    furnish,
    ids,
    instance,
    router,
    snapshot,
)

ROUTER = router()
SURE = snapshot(noise=0.3)
UNSURE = snapshot(noise=2.5)


def route(text, scene=SURE):
    return ROUTER.answer(scene, ROUTER.read(text))


def best(answer):
    return answer.matches[0].instance.instance_id


@pytest.mark.parametrize(
    ("text", "expected"),
    [("couch", 3), ("where is the lamp?", 16), ("red cup", 6), ("blue cup", 7), ("wall", 2)],
)
def test_a_sure_encoder_answers_at_once(text, expected):
    routed = route(text)
    assert routed.enough
    assert routed.answer.status == "found"
    assert routed.answer.route == "fast"
    assert best(routed.answer) == expected
    assert routed.answer.revision == Revision(5, 12, 110, 9_000)


def test_three_chairs_are_ambiguous():
    routed = route("chair")
    assert routed.answer.status == "ambiguous"
    assert not routed.enough
    assert {m.instance.instance_id for m in routed.answer.matches[:3]} == ids("chair")
    assert routed.answer.confidence.p_max == pytest.approx(1 / 3, abs=0.05)


@pytest.mark.parametrize("text", ["bathtub", "grand piano", "bicycle"])
def test_what_is_not_there_is_not_found(text):
    routed = route(text)
    assert routed.answer.status == "not_found"
    assert routed.enough
    assert text in routed.answer.reason


@pytest.mark.parametrize("text", ["couch", "lamp", "red cup", "bathtub", "grand piano"])
def test_a_weak_encoder_is_never_bold(text):
    assert route(text, UNSURE).answer.status != "found"


def test_a_weak_encoder_still_ranks():
    assert best(route("blue cup", UNSURE).answer) == 7


def test_a_descriptor_close_to_every_text_does_not_win():
    """A hub: larger cosines with all words than the right instance has with its own."""
    labels = ROUTER.labeller.text_vectors
    scene = furnish(noise=2.5)
    hub = labels.sum(axis=0)
    hub = (hub / np.linalg.norm(hub)).astype(np.float32)
    scene.apply_descriptors(5, {1: hub}, np.zeros(0, np.int32))
    answer = route("lamp", scene.snapshot()).answer
    assert best(answer) == 16


def test_an_empty_map_is_a_well_formed_answer():
    routed = route("cup", snapshot(things=()))
    assert routed.answer.status == "not_found"
    assert routed.answer.reason == "the map is empty: 0 instances, none with a descriptor yet"
    assert routed.answer.matches == ()
    assert routed.problem is None


def test_a_relation_goes_to_the_reasoner_with_candidates_for_all_words():
    routed = route("cup on the coffee table")
    assert not routed.enough
    assert routed.answer.status == "ambiguous"
    assert routed.answer.reason == "ranked by 'cup' only, without 'on coffee table'"
    targets = [c for c in routed.problem.candidates if c.role == "target"]
    anchors = [c for c in routed.problem.candidates if c.role == "anchor"]
    assert [c.instance_id for c in targets][:2] == [6, 7]
    assert anchors[0].instance_id == 5
    assert {c.words for c in anchors} == {"coffee table"}
    assert len(targets) == len(anchors) == 10


def test_a_missing_anchor_is_not_found():
    answer = route("chair next to the bathtub").answer
    assert answer.status == "not_found"
    assert "'bathtub'" in answer.reason


def test_candidates_for_anything_are_those_around_the_anchor():
    routed = route("what is on the coffee table?")
    targets = [c.instance_id for c in routed.problem.candidates if c.role == "target"]
    assert 6 in targets[:3]
    assert 5 not in targets


def test_a_verdict_becomes_a_reasoned_answer():
    routed = route("cup on the coffee table")
    answer = ROUTER.conclude(SURE, routed, Verdict(((6, 0.9), (7, 0.05)), "it is on it", 2))
    assert (answer.status, answer.route, answer.vlm_calls) == ("found", "reasoned", 2)
    assert [m.instance.instance_id for m in answer.matches] == [6, 7]
    assert answer.confidence.p_max == pytest.approx(0.9)
    assert answer.reason == "it is on it"


def test_a_close_verdict_asks_which_one():
    routed = route("cup on the coffee table")
    answer = ROUTER.conclude(SURE, routed, Verdict(((6, 0.5), (7, 0.45)), "either", 0))
    assert answer.status == "ambiguous"


def test_a_verdict_does_not_make_a_weak_encoder_bold():
    routed = route("pillow on the couch", UNSURE)
    answer = ROUTER.conclude(UNSURE, routed, Verdict(((4, 0.95),), "on it", 0))
    assert answer.status == "ambiguous"
    assert answer.reason == "on it; but the encoder is not sure that these are such things"


def test_an_empty_verdict_keeps_the_evidence():
    routed = route("lamp on the coffee table")
    answer = ROUTER.conclude(SURE, routed, Verdict((), "none is", 0))
    assert answer.status == "not_found"
    assert best(answer) == 16


def test_a_verdict_about_strangers_is_refused():
    with pytest.raises(ValueError, match="instance 99 was not a candidate"):
        ROUTER.conclude(SURE, route("cup on the lamp"), Verdict(((99, 1.0),), "?", 0))


def test_fallback_keeps_the_encoders_answer_and_says_why():
    routed = route("chair")
    answer = ROUTER.fall_back(routed, "no reasoner answered")
    assert answer.route == "fallback"
    assert answer.reason.startswith("no reasoner answered; not sure which")
    assert answer.matches == routed.answer.matches


def test_labels_come_with_their_gate():
    naming = ROUTER.namer.label(SURE, SURE.find(16), k=3)
    assert naming.status == "found"
    assert naming.labels[0].name == "lamp"
    assert len(naming.labels) == 3
    assert ROUTER.namer.label(UNSURE, UNSURE.find(16)).status == "ambiguous"


def test_scores_far_out_do_not_make_an_encoder_bolder_than_it_has_been_right():
    encoder = WordEncoder()
    encoder.ceiling = 0.45
    modest = Router(RouterParams(), encoder, Labeller(named("scannet200"), encoder))
    naming = modest.namer.label(SURE, SURE.find(16))
    assert naming.labels[0].name == "lamp"
    assert naming.labels[0].p == pytest.approx(0.45)
    assert naming.status == "ambiguous"
    answer = modest.answer(SURE, modest.read("lamp")).answer
    assert best(answer) == 16
    assert (answer.status, answer.presence) == ("ambiguous", pytest.approx(0.45))


def test_probabilities_over_instances_add_up_to_one():
    answer = route("cup").answer
    assert sum(m.p for m in answer.matches) == pytest.approx(1.0)


def test_descriptors_without_views_or_geometry_do_not_answer():
    scene = furnish()
    scene.apply_views(5, {16: ()})
    scene.apply_map(
        Revision(5, 13), [instance(6, ROOM[5], state="removed")], np.zeros(3), full=False
    )
    scene.apply_descriptors(5, {}, np.array([7], np.int32))
    found = [one.instance_id for one in scene.snapshot().instances]
    assert found == [i for i in range(1, 17) if i not in (6, 7, 16)]
    assert scene.snapshot().up_world.tolist() == [0.0, 0.0, 1.0]


def test_views_of_another_map_do_not_answer():
    scene = furnish()
    scene.apply_map(Revision(6, 1), [instance(1, ROOM[0])], np.zeros(3), full=True)
    assert len(scene.snapshot()) == 0
    assert scene.snapshot().instance_count == 1


def test_a_snapshot_does_not_change_afterwards():
    scene = furnish()
    before = scene.snapshot()
    scene.apply_descriptors(
        5,
        {16: descriptors((Thing("box", (0, 0, 0), (1, 1, 1)),), 0.1)[1]},
        np.zeros(0, np.int32),
    )
    assert before.instances[15].label.name == "lamp"
    assert scene.snapshot().instances[15].label.name == "box"


def test_a_descriptor_of_another_encoder_is_refused():
    scene = furnish()
    assert not scene.accepts(np.zeros(3, np.float32))
    with pytest.raises(ValueError, match="descriptor of instance 2: expected 256 finite numbers"):
        scene.apply_descriptors(5, {2: np.zeros(3, np.float32)}, np.zeros(0, np.int32))


def test_thresholds_are_checked():
    with pytest.raises(ValueError, match="top_k"):
        RouterParams(top_k=0)
    with pytest.raises(ValueError, match="min_claim"):
        JudgeParams(min_claim=2.0)
    strict = router(RouterParams(judge=replace(JudgeParams(), min_claim=1.0)))
    assert strict.answer(SURE, strict.read("lamp")).answer.status == "ambiguous"


def with_structure():
    """The furnished room whose map knows what its floor and its wall are."""
    known = furnish()
    structure = {1: "floor", 2: "wall"}
    roles = [
        replace(instance(i + 1, thing), role=structure.get(i + 1, "object"))
        for i, thing in enumerate(ROOM)
    ]
    known.apply_map(Revision(5, 13, 120, 9_500), roles, np.array([0.0, 0.0, 1.0]), full=False)
    return known.snapshot()


@pytest.mark.parametrize(("text", "expected"), [("where is the floor?", 1), ("the wall", 2)])
def test_parts_of_the_building_are_found_by_their_role(text, expected):
    routed = route(text, with_structure())
    assert routed.answer.status == "found"
    assert [m.instance.instance_id for m in routed.answer.matches] == [expected]
    assert routed.answer.matches[0].instance.label.name == ROOM[expected - 1].name


@pytest.mark.parametrize("text", ["couch", "chair", "what is on the coffee table?"])
def test_structure_is_kept_out_of_answers_about_objects(text):
    routed = route(text, with_structure())
    told = {m.instance.instance_id for m in routed.answer.matches}
    asked = {c.instance_id for c in routed.problem.candidates if c.role == "target"}
    assert told
    assert asked
    assert not (told | asked) & {1, 2}


def test_the_floor_may_be_an_anchor():
    routed = route("the box on the floor", with_structure())
    anchors = [c.instance_id for c in routed.problem.candidates if c.role == "anchor"]
    assert anchors == [1]


def test_a_map_of_structure_alone_has_no_objects():
    known = furnish()
    walls = [replace(instance(i + 1, thing), role="wall") for i, thing in enumerate(ROOM)]
    known.apply_map(Revision(5, 13, 120, 9_500), walls, np.array([0.0, 0.0, 1.0]), full=False)
    assert route("couch", known.snapshot()).answer.status == "not_found"
    assert route("what is on the couch?", known.snapshot()).answer.matches == ()


def test_what_nothing_can_be_an_anchor_of_is_not_asked_of_a_reasoner():
    known = furnish()
    walls = [replace(instance(i + 1, thing), role="wall") for i, thing in enumerate(ROOM)]
    known.apply_map(Revision(5, 13, 120, 9_500), walls, np.array([0.0, 0.0, 1.0]), full=False)
    routed = route("the wall next to the couch", known.snapshot())
    assert (routed.answer.status, routed.enough, routed.problem) == ("not_found", True, None)
