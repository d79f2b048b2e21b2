"""Answers of a router that knows how probable "none of them" is."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.reasoning.reasoner import Verdict
from sceneq_core.routing.judge import JudgeParams
from sceneq_core.routing.null import NullParams
from sceneq_core.routing.router import Router, RouterParams
from sceneq_core.routing.saying import say
from sceneq_core.routing.sureness import Sureness

from support.furnished import ids, router, snapshot

NULL = NullParams(temperature=0.1, name=1.0, said=1.0, standing=1.0, bias=-3.0)
SURE = snapshot()


def calibrated(null: NullParams = NULL, **judge: float) -> Router:
    params = RouterParams(judge=replace(JudgeParams(), **judge), null=null)
    return router(params)


ROUTER = calibrated()


def route(text, asked=ROUTER):
    return asked.answer(SURE, asked.read(text))


@pytest.mark.parametrize("text", ["lamp", "cup", "aquarium", "red cup", "the box near the chair"])
def test_all_matches_and_none_of_them_add_up_to_one(text):
    answer = route(text).answer
    assert sum(match.p for match in answer.matches) + answer.confidence.p_null == pytest.approx(1)
    assert 0 < answer.confidence.p_null < 1


def test_a_thing_that_is_there_is_found_and_one_that_is_not_is_not():
    lamp, aquarium = route("lamp"), route("aquarium")
    assert (lamp.answer.status, lamp.enough) == ("found", True)
    assert (aquarium.answer.status, aquarium.enough) == ("not_found", True)
    assert "there is no 'aquarium' with p 0." in aquarium.answer.reason
    assert lamp.answer.confidence.p_null < 0.1 < 0.4 < aquarium.answer.confidence.p_null
    assert len(aquarium.answer.matches) == len(SURE)  # still there to see


def test_words_that_describe_have_a_none_of_them_of_their_own():
    params = RouterParams(null=NULL, null_described=replace(NULL, name=0.2, bias=1.0))
    both = router(params)
    vague, name = (route(text, both).answer for text in ("something to drink from", "aquarium"))
    assert route("something to drink from").answer.status == "not_found"
    assert (vague.status, name.status) == ("ambiguous", "not_found")
    assert vague.confidence.p_null < 0.4
    assert name == route("aquarium").answer


def test_words_that_describe_have_a_sureness_of_their_own():
    described = replace(NULL, name=0.0, bias=3.0)
    usual = RouterParams(null=NULL, null_described=described)
    surer = router(replace(usual, sureness_described=Sureness(slope=1.5, shift=1.0)))
    before, after = (route("a place to drink", r).answer for r in (router(usual), surer))
    was, now = before.confidence, after.confidence
    assert np.log(now.p_max / (1 - now.p_max)) == pytest.approx(
        1.5 * np.log(was.p_max / (1 - was.p_max)) + 1.0
    )
    assert [m.instance.instance_id for m in after.matches] == [
        m.instance.instance_id for m in before.matches
    ]
    assert sum(match.p for match in after.matches) + now.p_null == pytest.approx(1)
    assert after.presence == pytest.approx(1 - now.p_null)
    assert route("lamp", surer).answer == route("lamp", router(usual)).answer


def test_each_thing_of_a_description_is_judged_by_itself():
    asked = router(RouterParams(null=NULL, null_described=replace(NULL, name=0.0, bias=5.0)))
    question = asked.read("things to drink from")
    routed = asked.answer(SURE, question)
    assert routed.answer.confidence.p_null < 0.1  # it is sure that there is something
    count = asked.reporter.report("count", SURE, question, routed.answer, routed.fits)
    exists = asked.reporter.report("exists", SURE, question, routed.answer, routed.fits)
    assert (count.tally.sure, exists.exists) == ((), "unsure")


def test_which_of_several_is_asked_back():
    answer = route("chair").answer
    assert answer.status == "ambiguous"
    assert answer.confidence.p_null < 0.1
    assert {match.instance.instance_id for match in answer.matches[:3]} == ids("chair")


def test_the_probability_to_be_right_is_that_of_what_is_claimed():
    lamp, aquarium, chair = (route(text).answer for text in ("lamp", "aquarium", "chair"))
    assert lamp.p_right == lamp.confidence.p_max == lamp.matches[0].p
    assert aquarium.p_right == aquarium.confidence.p_null
    assert chair.p_right == chair.matches[0].p < 0.67


def test_presence_is_the_rest_of_none_of_them():
    answer = route("lamp").answer
    assert answer.presence == pytest.approx(1 - answer.confidence.p_null)


def test_the_order_is_that_without_a_calibration():
    plain = router()
    for text in ("cup", "red cup", "table"):
        without = plain.answer(SURE, plain.read(text)).answer.matches
        order = [match.instance.instance_id for match in without]
        assert [match.instance.instance_id for match in route(text).answer.matches] == order


def test_a_missing_anchor_makes_none_of_them_likely():
    answer = route("the cup on the aquarium").answer
    assert answer.status == "not_found"
    assert "there is no 'aquarium'" in answer.reason
    assert answer.p_right == pytest.approx(route("aquarium").answer.confidence.p_null)


def test_an_anchor_is_denied_only_as_boldly_as_a_thing_is_found():
    shy = calibrated(NullParams(0.1, 0.0, 0.0, 0.0, bias=-0.3))  # none of anything: 0.57
    assert route("aquarium", shy).answer.status == "not_found"
    assert route("anything on the aquarium", shy).answer.status == "ambiguous"
    bold = calibrated(NullParams(0.1, 0.0, 0.0, 0.0, bias=-0.3), min_claim=0.55)
    answer = route("anything on the aquarium", bold).answer
    assert (answer.status, answer.reason) == ("not_found", "there is no 'aquarium' with p 0.57")


def test_what_is_called_so_but_denied_is_said_to_be_doubtful():
    lamp, aquarium = said("lamp"), said("aquarium")
    assert lamp.startswith("There is probably no lamp; the lamp (16) ")
    assert lamp.endswith(" is a doubtful one.")
    assert aquarium.startswith("There is no aquarium; the nearest miss is the ")


def said(words):
    shy = calibrated(NullParams(0.1, 0.0, 0.0, 0.0, bias=-1.5))
    question = shy.read(words)
    routed = shy.answer(SURE, question)
    return say(shy.reporter.report("which", SURE, question, routed.answer, routed.fits), 0)


def test_anything_is_always_there_and_a_colour_may_not_be():
    assert route("what is on the coffee table?").answer.confidence.p_null < 0.1
    assert route("what is on the aquarium?").answer.confidence.p_null > 0.4


def test_asking_back_that_costs_nothing_leaves_nothing_to_claim():
    asked = calibrated(min_claim=1.0, min_absence=1.0)
    assert {route(text, asked).answer.status for text in ("lamp", "aquarium")} == {"ambiguous"}


def test_an_absence_must_be_likelier_than_any_thing():
    half = calibrated(NullParams(0.1, 0.0, 0.0, 0.0, bias=0.3), min_absence=0.0)
    answer = route("lamp", half).answer  # none 0.43, the lamp more
    assert answer.confidence.p_null < answer.confidence.p_max
    assert answer.status == "ambiguous"


def test_a_reasoner_shares_what_none_of_them_leaves():
    routed = route("the box near the chair")
    box = routed.answer.matches[0].instance.instance_id
    answer = ROUTER.conclude(SURE, routed, Verdict(((box, 0.9), (12, 0.1)), "seen", 1))
    present = 1 - routed.answer.confidence.p_null
    assert [match.p for match in answer.matches] == pytest.approx([0.9 * present, 0.1 * present])
    assert answer.confidence.p_null == routed.answer.confidence.p_null
    assert answer.status == "found"


def test_a_reasoner_that_has_not_looked_does_not_find_what_is_not_there():
    routed = route("aquarium")
    first = routed.answer.matches[0].instance.instance_id
    blind = ROUTER.conclude(SURE, routed, Verdict(((first, 1.0),), "the only one", 0))
    seeing = ROUTER.conclude(SURE, routed, Verdict(((first, 1.0),), "the picture shows it", 1))
    assert (blind.status, seeing.status) == ("not_found", "ambiguous")


def test_an_empty_map_surely_has_none():
    nothing = snapshot(())
    answer = ROUTER.answer(nothing, ROUTER.read("lamp")).answer
    assert (answer.status, answer.p_right, answer.matches) == ("not_found", 1.0, ())


def test_a_reasoner_gets_how_probably_each_is_of_the_kind_that_is_named():
    problem = route("the chair near the box").problem
    kind = {one.instance_id: one.p for one in problem.candidates if one.role == "target"}
    chairs = [kind.pop(instance_id) for instance_id in ids("chair")]
    assert min(chairs) > 0.8  # of three chairs each is one, and no less because of the others
    assert max(kind.values()) < 0.05
    alone = route("chair").problem.candidates
    meant = [match.p for match in route("chair").answer.matches]
    assert alone[0].p / alone[1].p == pytest.approx(meant[0] / meant[1])
    assert sum(one.p for one in alone) <= 1.0


def test_the_temperature_of_the_evidence_is_not_that_of_the_kind():
    warm = calibrated(replace(NULL, temperature=0.4))  # the encoder has T 0.1
    same = [route("the chair near the box", one).problem.candidates for one in (ROUTER, warm)]
    assert [one.p for one in same[0]] == [one.p for one in same[1]]
    told = [route("chair", one).answer.presence for one in (ROUTER, warm)]
    assert told[1] < told[0]
