"""A router with two calibrations, one of them for rooms that look strange to the encoder."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.mapping.delta import FLOOR
from sceneq_core.routing.null import NullParams
from sceneq_core.routing.router import RouterParams
from sceneq_core.routing.scene import SceneSnapshot
from sceneq_core.routing.sureness import Sureness
from sceneq_core.routing.unfamiliar import Unfamiliar, scene_familiarity

from support.furnished import ROOM, descriptors, furnish, ids, router

NULL = NullParams(temperature=0.1, name=1.0, said=1.0, standing=1.0, bias=-3.0)
TIMID = NullParams(temperature=0.2, name=0.3, said=0.0, standing=0.1, bias=-1.0)
STRANGE = Unfamiliar(0.2, middle=0.8, slope=100.0, null=TIMID)
MIXED = router(RouterParams(null=NULL, unfamiliar=STRANGE))
HOME = router(RouterParams(null=NULL))


def seen(familiarity: float | list[float]) -> SceneSnapshot:
    """The furnished room, as familiar as this, or its instances one by one."""
    scene, rows = furnish(), descriptors(ROOM, 0.3)
    values = np.broadcast_to(familiarity, len(rows)).tolist()
    scene.apply_descriptors(5, rows, np.zeros(0, np.int32), dict(zip(rows, values, strict=True)))
    return scene.snapshot()


def answer(asked, text, snapshot):
    return asked.answer(snapshot, asked.read(text)).answer


@pytest.mark.parametrize("text", ["lamp", "cup", "aquarium", "red cup", "the box near the chair"])
def test_a_familiar_room_is_answered_as_if_there_were_no_other(text):
    room = seen(0.95)
    assert answer(MIXED, text, room) == answer(HOME, text, room)


def test_a_strange_room_makes_it_less_sure_with_the_same_order():
    for text in ("lamp", "red cup", "dining table"):
        familiar, strange = answer(MIXED, text, seen(0.95)), answer(MIXED, text, seen(0.6))
        assert (familiar.status, strange.status) == ("found", "ambiguous")
        assert strange.confidence.p_max < familiar.confidence.p_max - 0.2
        best, other = (one.matches[0].instance.instance_id for one in (familiar, strange))
        assert best == other
        total = sum(match.p for match in strange.matches) + strange.confidence.p_null
        assert total == pytest.approx(1)


def test_in_between_both_count_by_how_familiar_the_room_is():
    room = seen(0.81)
    share = 1 / (1 + np.exp(100 * 0.01))
    home, strange = answer(HOME, "lamp", room), answer(MIXED, "lamp", seen(0.0))
    between = answer(MIXED, "lamp", room)
    p = [one.matches[0].p for one in (home, strange, between)]
    assert p[2] == pytest.approx((1 - share) * p[0] + share * p[1], abs=1e-6)
    nulls = [one.confidence.p_null for one in (home, strange, between)]
    assert nulls[2] == pytest.approx((1 - share) * nulls[0] + share * nulls[1], abs=1e-6)
    assert sum(m.p for m in between.matches) + nulls[2] == pytest.approx(1)


def test_which_of_the_candidates_is_such_a_thing_is_said_half_by_either():
    question, room = MIXED.read("the cup on the coffee table"), seen(0.3)
    abroad = router(RouterParams(null=TIMID), temperature=0.2)
    fits = [one.fits(room, question)["cup"].kind for one in (HOME, abroad, MIXED)]
    assert fits[2] == pytest.approx((fits[0] + fits[1]) / 2, abs=1e-9)
    assert MIXED.fits(seen(0.95), question)["cup"].kind == pytest.approx(fits[0])


def test_how_sure_descriptions_are_depends_on_the_room_too():
    sure = replace(STRANGE, null_described=replace(TIMID, bias=5.0), sureness_described=None)
    surer = replace(sure, sureness_described=Sureness(slope=1.5, shift=2.0))
    plain, bold = (router(RouterParams(null=NULL, unfamiliar=one)) for one in (sure, surer))
    text = "something to drink from"
    p = [answer(one, text, seen(0.2)).confidence.p_max for one in (plain, bold)]
    assert np.log(p[1] / (1 - p[1])) == pytest.approx(1.5 * np.log(p[0] / (1 - p[0])) + 2)


def test_counting_is_as_careful_as_finding():
    hesitant = Unfamiliar(0.1, middle=0.8, slope=100.0, null=replace(NULL, bias=-3.7))
    asked = router(RouterParams(null=NULL, unfamiliar=hesitant))

    def tally(snapshot):
        question = asked.read("how many chairs", many=True)
        routed = asked.answer(snapshot, question)
        report = asked.reporter.report("count", snapshot, question, routed.answer, routed.fits)
        return report.tally

    familiar, strange, between = tally(seen(0.95)), tally(seen(0.5)), tally(seen(0.8))
    assert {m.instance.instance_id for m in familiar.sure} == ids("chair")
    assert len(strange.sure) < len(familiar.sure)
    p = [one.matches[0].p for one in (strange, between, familiar)]
    assert p[1] == pytest.approx((p[0] + p[2]) / 2)  # at the middle each counts half
    assert p[0] < p[2]


def test_a_room_is_as_familiar_as_the_most_familiar_tenth_of_its_objects():
    values = [0.1] * 14 + [0.7, 0.9]
    assert scene_familiarity(seen(values).columns) == pytest.approx(0.8)  # two of sixteen
    assert scene_familiarity(seen(0.3).columns) == pytest.approx(0.3)
    assert scene_familiarity(furnish(ROOM[:0]).snapshot().columns) == 1.0


def test_floor_and_walls_do_not_make_a_room_familiar():
    columns = seen([1.0] + [0.2] * 15).columns
    role = columns.role.copy()
    role[0] = FLOOR
    assert scene_familiarity(replace(columns, role=role)) == pytest.approx(0.2)


def test_what_nobody_tells_is_familiar():
    assert scene_familiarity(furnish().snapshot().columns) == 1.0


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"temperature": 0.0}, "temperature"),
        ({"middle": 1.5}, "middle"),
        ({"slope": -1.0}, "slope"),
        ({"slope": float("inf")}, "slope"),
    ],
)
def test_parameters_that_cannot_be_are_refused(changes, complaint):
    with pytest.raises(ValueError, match=complaint):
        replace(STRANGE, **changes)
