"""The families of spatial language of ReferIt3D, each on a small scene made by hand.

P. Achlioptas et al., "ReferIt3D", ECCV 2020, DOI 10.1007/978-3-030-58452-8_25. All scenes are seen
from (0, -3, 1.5) towards +y: right is +x.
"""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.reasoning.geometric import GeometricParams, GeometricReasoner
from sceneq_core.reasoning.reasoner import Candidate, Constraint, Problem

from support.furnished import UP, VIEWPOINT, Thing, instance

REASONER = GeometricReasoner(GeometricParams())


def at(name, x, y, z=0.0, size=(0.3, 0.3, 0.3)):
    low = (x - size[0] / 2, y - size[1] / 2, z)
    return Thing(name, low, tuple(np.add(low, size)))


def pose(target, constraint, things):
    """Every thing is a candidate for the words it is called, sure, and for no other."""
    named = [("target", target), *(("anchor", words) for words in constraint.things)]
    candidates = [
        candidate(key, thing, role, words)
        for role, words in named
        for key, thing in enumerate(things, 1)
        if thing.name == words
    ]
    return Problem("", target, (constraint,), tuple(candidates), UP, VIEWPOINT)


def candidate(key, thing, role, words):
    one = instance(key, thing)
    return Candidate(
        instance_id=key,
        role=role,
        words=words,
        label=thing.name,
        p=1.0,
        cosine=1.0,
        centre_world=one.centre_world,
        T_world_box=one.T_world_box,
        box_size_m=one.box_size_m,
        views=(),
    )


def solve(target, constraint, things):
    return REASONER.solve(pose(target, constraint, things))


ROW = [at("chair", x, 1.0) for x in (-2.0, -0.5, 0.7, 2.0)]
SINK = at("sink", 0.0, 0.0)
MUGS = [at("mug", 0.36, 0.0, size=(0.1, 0.1, 0.1)), at("mug", 1.6, 0.0, size=(0.1, 0.1, 0.1))]
BOXES = [at("box", x, 1.0, size=(s, s, s)) for x, s in ((-1, 0.2), (0, 0.6), (1, 0.4))]
POLES = [at("pole", x, 1.0, size=(0.1, 0.1, h)) for x, h in ((-1, 1.0), (0, 2.0), (1, 1.5))]
PLANKS = [at("plank", 0, y, size=(w, 0.1, 0.1)) for y, w in ((0, 1.0), (1, 2.0), (2, 0.5))]


@pytest.mark.parametrize(
    ("relation", "anchor", "rank", "things", "expected"),
    [
        ("nearest", "sink", 1, [*MUGS, SINK], 1),
        ("farthest", "sink", 1, [*MUGS, SINK], 2),
        ("nearest", "sink", 2, [*MUGS, SINK], 2),
        ("leftmost", "", 1, ROW, 1),
        ("leftmost", "", 2, ROW, 2),
        ("leftmost", "", 3, ROW, 3),
        ("rightmost", "", 1, ROW, 4),
        ("rightmost", "", 2, ROW, 3),
        ("largest", "", 1, BOXES, 2),
        ("largest", "", 2, BOXES, 3),
        ("largest", "", 3, BOXES, 1),
        ("smallest", "", 1, BOXES, 1),
        ("tallest", "", 1, POLES, 2),
        ("tallest", "", 2, POLES, 3),
        ("shortest", "", 1, POLES, 1),
        ("longest", "", 1, PLANKS, 2),
        ("widest", "", 2, PLANKS, 1),
        ("narrowest", "", 1, BOXES, 1),
        ("highest", "", 1, [at("cup", 0, 0, z) for z in (0.5, 1.5)], 2),
        ("lowest", "", 1, [at("cup", 0, 0, z) for z in (0.5, 1.5)], 1),
    ],
)
def test_superlatives_and_ordinals(relation, anchor, rank, things, expected):
    verdict = solve(things[0].name, Constraint(relation, anchor, rank=rank), things)
    assert verdict.ranking[0][0] == expected
    assert verdict.ranking[0][1] > 0.5


@pytest.mark.parametrize(
    ("relation", "expected"),
    [
        ("left_of", 2),
        ("right_of", 3),
        ("in_front_of", 4),
        ("behind", 5),
        ("on", 6),
        ("above", 7),
        ("under", 8),
        ("far_from", 9),
    ],
)
def test_a_desk_and_what_is_around_it(relation, expected):
    things = [
        at("desk", 0, 0, 0.6, size=(1.0, 0.6, 0.1)),
        at("bin", -1.0, 0),
        at("bin", 1.0, 0),
        at("bin", 0, -1.0),
        at("bin", 0, 1.0),
        at("bin", 0, 0, 0.7, size=(0.2, 0.2, 0.2)),
        at("bin", 0, 0, 1.3, size=(0.2, 0.2, 0.2)),
        at("bin", 0, 0, 0.0, size=(0.2, 0.2, 0.2)),
        at("bin", 6.0, 6.0),
    ]
    verdict = solve("bin", Constraint(relation, "desk"), things)
    assert verdict.ranking[0][0] == expected


def test_between_needs_both_anchors():
    things = [
        at("sofa", -1.5, 0),
        at("desk", 1.5, 0),
        at("bin", 0, 0.1),
        at("bin", 2.3, 0),
        at("bin", 0, 3.0),
        at("bin", -1.5, 0.4),
    ]
    verdict = solve("bin", Constraint("between", "sofa", other="desk"), things)
    assert verdict.ranking[0][0] == 3
    assert verdict.ranking[0][1] > 0.7
    assert verdict.reason == "4 bins; instance 3 ('bin') is between instance 1 ('sofa') and 'desk'"


def test_between_two_of_the_same():
    things = [at("window", -1, 3), at("window", 1, 3), at("lamp", 0, 3), at("lamp", 3, 3)]
    verdict = solve("lamp", Constraint("between", "window", other="window"), things)
    assert verdict.ranking[0][0] == 3


@pytest.mark.parametrize(
    ("constraint", "expected", "frame"),
    [
        (Constraint("left_of", "desk"), 2, "seen from the viewer"),
        (Constraint("left_of", "desk", seen_from="door"), 3, "seen from instance 4 ('door')"),
        (Constraint("left_of", "desk", facing="door"), 2, "facing instance 4 ('door')"),
        (Constraint("leftmost", ""), 2, "seen from the viewer"),
        (Constraint("rightmost", "", seen_from="door"), 2, "seen from instance 4 ('door')"),
    ],
)
def test_the_frame_of_left_and_right_is_stated(constraint, expected, frame):
    things = [at("desk", 0, 0), at("bin", -1, 0), at("bin", 1, 0), at("door", 0, 3)]
    verdict = solve("bin", constraint, things)
    assert verdict.ranking[0][0] == expected
    assert verdict.reason.endswith(frame)


def test_what_the_viewer_faces_turns_left_and_right():
    things = [at("desk", 0, 0), at("bin", 0, -1), at("bin", 0, 1), at("door", 5, -3)]
    verdict = solve("bin", Constraint("left_of", "desk", facing="door"), things)
    assert verdict.ranking[0][0] == 3


def test_what_is_not_so_is_the_rest():
    things = [*MUGS, SINK]
    near = solve("mug", Constraint("next_to", "sink"), things)
    far = solve("mug", Constraint("next_to", "sink", negated=True), things)
    assert (near.ranking[0][0], far.ranking[0][0]) == (1, 2)
    assert "is not next to instance 3 ('sink')" in far.reason


def test_the_table_with_a_lamp_on_it():
    tables = [at("table", x, 0, size=(1.0, 0.8, 0.7)) for x in (-2, 2)]
    things = [*tables, at("lamp", 2.1, 0, 0.7)]
    verdict = solve("table", Constraint("supports", "lamp"), things)
    assert verdict.ranking[0][0] == 2
    assert verdict.reason.endswith("is supporting instance 3 ('lamp')")
    shelf = at("shelf", 0, 0, size=(1.0, 0.4, 2.0))
    inside = solve("shelf", Constraint("contains", "lamp"), [shelf, at("lamp", 0, 0, 0.5)])
    assert inside.ranking[0][0] == 1


def test_the_reason_says_how_many_there_are_and_how_far_they_are():
    verdict = solve("mug", Constraint("nearest", "sink"), [*MUGS, SINK])
    assert verdict.reason == (
        "2 mugs; instance 1 ('mug') is the nearest to instance 3 ('sink'), 0.16 m away, "
        "the other 1.4"
    )
    tallest = solve("pole", Constraint("tallest", ""), POLES)
    assert tallest.reason == "3 poles; instance 2 ('pole') is the tallest, 2 m tall, the next 1.5"


def test_a_place_in_a_row_that_nobody_has():
    verdict = solve("chair", Constraint("leftmost", "", rank=7), ROW)
    assert verdict.ranking == ()
    assert verdict.reason == "none of the candidates for 'chair' is the 7th leftmost"


def test_holding_does_not_depend_on_the_words():
    posed = pose("mug", Constraint("next_to", "sink"), [*MUGS, SINK])
    doubtful = replace(posed, candidates=tuple(replace(c, p=0.01) for c in posed.candidates))
    holds = REASONER.holds(posed)
    assert holds == REASONER.holds(doubtful)
    assert holds[1] > 0.5 > holds[2]
