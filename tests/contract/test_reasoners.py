"""What every reasoner promises."""

import numpy as np
import pytest

from sceneq_core.reasoning.reasoner import Candidate, Constraint, Problem
from sceneq_nodes._backends import build, kinds

KINDS = sorted(kinds("reasoner"))


def candidate(instance_id, role, words, p, centre):
    T_world_box = np.eye(4)
    T_world_box[:3, 3] = centre
    return Candidate(
        instance_id=instance_id,
        role=role,
        words=words,
        label=words,
        p=p,
        cosine=p,
        centre_world=np.array(centre, float),
        T_world_box=T_world_box,
        box_size_m=np.array([0.2, 0.2, 0.2]),
        views=((3, (0.0, 0.0, 9.0, 9.0)),),
    )


def problem(constraints, candidates):
    return Problem(
        text="the cup next to the lamp",
        target="cup",
        constraints=constraints,
        candidates=candidates,
        up_world=np.array([0.0, -1.0, 0.0]),
        viewpoint_world=np.array([0.0, 0.0, -2.0]),
    )


CUPS = (
    candidate(4, "target", "cup", 0.5, (0.0, 0.0, 0.0)),
    candidate(9, "target", "cup", 0.4, (3.0, 0.0, 0.0)),
)
LAMP = (candidate(2, "anchor", "lamp", 0.9, (3.3, 0.0, 0.0)),)
PROBLEMS = [
    problem((), CUPS),
    problem((), ()),
    problem((Constraint("next_to", "lamp"),), CUPS + LAMP),
    problem((Constraint("largest", ""),), CUPS),
    problem((Constraint("nearest", ""), Constraint("near", "lamp")), CUPS + LAMP),
]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("posed", PROBLEMS)
def test_a_verdict_ranks_targets_with_probabilities(kind, posed):
    verdict = build("reasoner", {"kind": kind}).solve(posed)
    targets = {c.instance_id for c in posed.candidates if c.role == "target"}
    ranked = [key for key, _ in verdict.ranking]
    p = [value for _, value in verdict.ranking]
    assert set(ranked) <= targets
    assert len(set(ranked)) == len(ranked)
    assert p == sorted(p, reverse=True)
    assert all(0.0 <= value <= 1.0 for value in p)
    assert sum(p) <= 1.0 + 1e-9
    assert verdict.reason
    assert verdict.vlm_calls >= 0


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_problem_gets_the_same_verdict(kind):
    reasoner = build("reasoner", {"kind": kind})
    assert reasoner.solve(PROBLEMS[2]) == reasoner.solve(PROBLEMS[2])
