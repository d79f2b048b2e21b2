"""What every reasoner promises."""

import numpy as np
import pytest

from sceneq_core.reasoning.reasoner import Constraint, LabelProblem, Problem
from sceneq_nodes._backends import build, kinds

from support.chat_server import chat_server, chooses_first
from support.seen_things import keyframe, thing
from support.tiny_vlm import write_tiny_vlm

KINDS = sorted(kinds("reasoner"))
VIEW = (3, (0.0, 0.0, 9.0, 9.0))


@pytest.fixture(scope="module")
def tiny_vlm(tmp_path_factory):
    pytest.importorskip("transformers", reason="the kind 'transformers' is an extra")
    return write_tiny_vlm(tmp_path_factory.mktemp("vlm"))


@pytest.fixture(params=KINDS)
def reasoner(request):
    """One of every kind, those with a model with one that chooses something."""
    if request.param == "openai":
        with chat_server(chooses_first) as chat:
            yield from opened({"kind": "openai", "base_url": chat.url, "model": "tiny"})
    elif request.param == "transformers":
        folder = request.getfixturevalue("tiny_vlm")
        yield from opened({"kind": "transformers", "model": str(folder), "device": "cpu"})
    else:
        yield from opened({"kind": request.param})


def opened(spec):
    built = build("reasoner", spec)
    yield built
    built.close()


def candidate(instance_id, role, words, p, centre):
    return thing(instance_id, p, VIEW, role=role, words=words, centre=centre)


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


LABELS = LabelProblem(4, (("cup", 0.5), ("mug", 0.3), ("lamp", 0.0)), (VIEW,))


def check(p, verdict):
    assert p == sorted(p, reverse=True)
    assert all(0.0 <= value <= 1.0 for value in p)
    assert sum(p) <= 1.0 + 1e-9
    assert verdict.reason
    assert verdict.vlm_calls >= 0
    assert (verdict.usage.tokens_in > 0) == (verdict.vlm_calls > 0)
    assert verdict.usage.money == 0.0


@pytest.mark.parametrize("posed", PROBLEMS)
def test_a_verdict_ranks_targets_with_probabilities(reasoner, posed):
    verdict = reasoner.solve(posed, keyframe)
    targets = {c.instance_id for c in posed.candidates if c.role == "target"}
    ranked = [key for key, _ in verdict.ranking]
    assert set(ranked) <= targets
    assert len(set(ranked)) == len(ranked)
    check([value for _, value in verdict.ranking], verdict)


def test_a_label_is_one_of_those_proposed(reasoner):
    verdict = reasoner.label(LABELS, keyframe)
    assert sorted(name for name, _ in verdict.ranking) == ["cup", "lamp", "mug"]
    check([value for _, value in verdict.ranking], verdict)
    assert sum(value for _, value in verdict.ranking) == pytest.approx(1.0)


def test_the_same_problem_gets_the_same_verdict(reasoner):
    once, twice = (reasoner.solve(PROBLEMS[2], keyframe) for _ in range(2))
    assert (once.ranking, once.reason) == (twice.ranking, twice.reason)
    once_named, twice_named = (reasoner.label(LABELS, keyframe) for _ in range(2))
    assert once_named.ranking == twice_named.ranking
