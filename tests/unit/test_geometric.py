"""The built-in reasoner on a furnished room."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.reasoning.geometric import GeometricParams, GeometricReasoner
from sceneq_core.reasoning.reasoner import Candidate, Constraint, Problem

from support.furnished import ROOM, UP, VIEWPOINT, Thing, ids, instance

REASONER = GeometricReasoner(GeometricParams())


def candidates(role, words, things=ROOM, p_other=0.001):
    """Everything in the room, sure where the name has the words."""
    meant = ids(words, things)
    p = {i + 1: (1.0 if i + 1 in meant else p_other) / len(meant) for i in range(len(things))}
    return tuple(candidate(i + 1, thing, role, words, p[i + 1]) for i, thing in enumerate(things))


def candidate(instance_id, thing, role, words, p):
    one = instance(instance_id, thing)
    return Candidate(
        instance_id=instance_id,
        role=role,
        words=words,
        label=thing.name,
        p=p,
        cosine=p,
        centre_world=one.centre_world,
        T_world_box=one.T_world_box,
        box_size_m=one.box_size_m,
        views=((10, (0.0, 0.0, 5.0, 5.0)),),
    )


def problem(target, relation, anchor, things=ROOM):
    anchors = candidates("anchor", anchor, things) if anchor else ()
    return Problem(
        text=f"{target} {relation} {anchor}",
        target=target,
        constraints=(Constraint(relation, anchor),) if relation else (),
        candidates=(*candidates("target", target, things), *anchors),
        up_world=UP,
        viewpoint_world=VIEWPOINT,
    )


def rotated(posed, rotation):
    """The same problem in a world that is turned by ``rotation`` (3, 3)."""
    T_turn = np.eye(4)
    T_turn[:3, :3] = rotation
    turned = tuple(
        replace(c, centre_world=rotation @ c.centre_world, T_world_box=T_turn @ c.T_world_box)
        for c in posed.candidates
    )
    return replace(
        posed,
        candidates=turned,
        up_world=rotation @ posed.up_world,
        viewpoint_world=rotation @ posed.viewpoint_world,
    )


CASES = [
    ("cup", "on", "coffee table", 6),
    ("cup", "on", "kitchen counter", 7),
    ("pillow", "on", "couch", 4),
    ("picture", "on", "wall", 9),
    ("picture", "above", "couch", 9),
    ("trash can", "next_to", "coffee table", 10),
    ("box", "under", "chair", 14),
    ("box", "in", "chair", 14),
    ("chair", "nearest", "dining table", 11),
    ("chair", "farthest", "dining table", 13),
    ("chair", "nearest", "kitchen counter", 12),
    ("table", "largest", "", 15),
    ("table", "lowest", "", 5),
    ("cup", "highest", "", 7),
    ("lamp", "left_of", "couch", 16),
    ("chair", "nearest", "", 11),
]


@pytest.mark.parametrize(("target", "relation", "anchor", "expected"), CASES)
def test_finds_the_one_that_is_meant(target, relation, anchor, expected):
    verdict = REASONER.solve(problem(target, relation, anchor))
    assert verdict.ranking[0][0] == expected
    assert verdict.ranking[0][1] > 0.5
    assert verdict.vlm_calls == 0


@pytest.mark.parametrize(("target", "relation", "anchor", "expected"), CASES)
def test_does_not_depend_on_the_direction_of_gravity(target, relation, anchor, expected):
    y_down = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    posed = problem(target, relation, anchor)
    here, there = REASONER.solve(posed), REASONER.solve(rotated(posed, y_down))
    assert [key for key, _ in there.ranking] == [key for key, _ in here.ranking]
    assert [p for _, p in there.ranking] == pytest.approx([p for _, p in here.ranking])


def test_the_reason_names_target_and_anchor():
    verdict = REASONER.solve(problem("cup", "on", "coffee table"))
    assert verdict.reason == "2 cups; instance 6 ('cup') is on instance 5 ('coffee table')"


def test_probabilities_leave_room_for_none_of_them():
    verdict = REASONER.solve(problem("chair", "near", "dining table"))
    assert 0.5 < sum(p for _, p in verdict.ranking) < 1.0


def test_nothing_on_it_is_an_empty_ranking():
    verdict = REASONER.solve(problem("lamp", "on", "coffee table"))
    assert verdict.ranking == ()
    assert verdict.reason == "none of the candidates for 'lamp' is on 'coffee table'"


def test_equal_chairs_are_equally_the_largest():
    verdict = REASONER.solve(problem("chair", "largest", ""))
    assert [p for _, p in verdict.ranking] == pytest.approx([0.3] * 3, abs=0.05)


def test_both_constraints_must_hold():
    posed = problem("cup", "on", "kitchen counter")
    both = replace(posed, constraints=(*posed.constraints, Constraint("lowest", "")))
    assert REASONER.solve(both).ranking[0][0] == 7


def test_a_thing_is_not_next_to_itself():
    verdict = REASONER.solve(problem("couch", "next_to", "couch"))
    assert 3 not in [key for key, p in verdict.ranking if p > 0.5]


def test_without_constraints_the_encoders_order_stays():
    verdict = REASONER.solve(problem("cup", "", ""))
    assert [key for key, _ in verdict.ranking][:2] == [6, 7]
    assert verdict.reason.startswith("which one?")


def test_left_follows_the_viewer_to_the_other_side():
    things = (
        Thing("desk", (-0.5, -0.5, 0), (0.5, 0.5, 0.7)),
        Thing("bin", (-1.2, -0.1, 0), (-1.0, 0.1, 0.3)),
    )
    posed = problem("bin", "left_of", "desk", things)
    assert REASONER.solve(posed).ranking[0][0] == 2
    behind = replace(posed, viewpoint_world=-VIEWPOINT)
    assert 2 not in [key for key, p in REASONER.solve(behind).ranking if p > 0.5]


def test_unusable_problems_are_named():
    with pytest.raises(ValueError, match="unknown 'orbiting'"):
        REASONER.solve(problem("cup", "orbiting", "lamp"))
    lost = replace(problem("cup", "on", "lamp"), candidates=candidates("target", "cup"))
    with pytest.raises(ValueError, match="none for the anchor 'lamp'"):
        REASONER.solve(lost)


def test_no_candidates_no_ranking():
    empty = replace(problem("cup", "", ""), candidates=())
    assert REASONER.solve(empty).ranking == ()
