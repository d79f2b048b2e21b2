"""What the scene graph says beats what boxes suggest."""

from dataclasses import replace

import pytest

from sceneq_core.reasoning.geometric import GeometricParams, GeometricReasoner
from sceneq_core.reasoning.known_relations import with_known
from sceneq_core.reasoning.reasoner import Candidate, Constraint, Problem

from support.furnished import ROOM, UP, VIEWPOINT, instance

CUP, TABLE, COUNTER = 6, 5, 8


def candidate(number, role="target", **known):
    one = instance(number, ROOM[number - 1])
    return Candidate(
        instance_id=number,
        role=role,
        words=ROOM[number - 1].name,
        label=ROOM[number - 1].name,
        p=1.0,
        cosine=1.0,
        centre_world=one.centre_world,
        T_world_box=one.T_world_box,
        box_size_m=one.box_size_m,
        views=(),
        **known,
    )


@pytest.mark.parametrize(
    ("relation", "known", "score"),
    [
        ("on", {"supported_by": TABLE}, 1.0),
        ("on", {"supported_by": COUNTER}, 0.2),
        ("on", {}, 0.4),
        ("in", {"inside": TABLE}, 1.0),
        ("in", {"supported_by": TABLE}, 0.4),
        ("next_to", {"supported_by": TABLE}, 0.2),
        ("next_to", {"supported_by": COUNTER}, 0.4),
        ("near", {"supported_by": TABLE}, 0.4),
    ],
)
def test_contact_that_was_seen_decides(relation, known, score):
    told = with_known(relation, candidate(CUP, **known), candidate(TABLE, "anchor"), 0.4)
    assert told == pytest.approx(score)


def test_a_carrier_is_under_what_it_carries():
    cup = candidate(CUP, "anchor", supported_by=TABLE)
    assert with_known("under", candidate(TABLE), cup, 0.1) == 1.0


def test_of_two_things_over_a_table_the_one_that_rests_on_it_is_meant():
    floating = replace(candidate(7), centre_world=candidate(CUP).centre_world)
    floating = replace(floating, T_world_box=candidate(CUP).T_world_box, supported_by=COUNTER)
    problem = Problem(
        text="what is on the coffee table?",
        target="",
        constraints=(Constraint("on", "coffee table"),),
        candidates=(floating, candidate(CUP, supported_by=TABLE), candidate(TABLE, "anchor")),
        up_world=UP,
        viewpoint_world=VIEWPOINT,
    )
    ranking = GeometricReasoner(GeometricParams()).solve(problem).ranking
    assert ranking[0][0] == CUP
    assert ranking[0][1] > 0.6
