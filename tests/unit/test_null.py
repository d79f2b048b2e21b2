"""The candidate "none of them", computed by hand."""

import numpy as np
import pytest

from sceneq_core.routing.null import NO_EVIDENCE, Evidence, NullParams, evidence_of

SEEN = Evidence(name=0.5, said=-0.2, standing=1.0)
NULL = NullParams(temperature=0.1, name=2.0, said=0.5, standing=1.0, bias=-1.2)


def test_none_of_them_is_one_more_choice_of_the_softmax():
    logits = np.array([2.0, 1.0])
    # l_0 = log(e^2 + e^1) - (-1.2 + 2 * 0.5 - 0.5 * 0.2 + 1 * 1.0) = 2.3133 - 0.7
    l_0 = np.log(np.exp(2.0) + np.exp(1.0)) - 0.7
    weights = np.exp([2.0, 1.0, l_0])
    p = weights / weights.sum()
    given = np.exp(logits) / np.exp(logits).sum()
    assert NULL.presence(SEEN) == pytest.approx(1 - p[2])
    assert NULL.presence(SEEN) * given == pytest.approx(p[:2])
    assert NULL.presence(SEEN) == pytest.approx(1 / (1 + np.exp(-0.7)))


def test_evidence_is_in_units_of_chance():
    seen = evidence_of(np.log([0.5, 0.25]), np.log([0.1, 0.9]), 0.5, labels=4, instances=8)
    assert seen.name == pytest.approx(np.log(2.0))
    assert seen.said == pytest.approx(np.log(0.9))  # of the one that fits name and colour best
    assert seen.standing == pytest.approx(np.log(4.0))
    blind = evidence_of(np.log([0.25]), np.zeros(1), 1 / 8, labels=4, instances=8)
    assert blind == Evidence(0.0, 0.0, 0.0)


def test_nothing_to_look_at_is_no_evidence():
    assert evidence_of(np.zeros(0), np.zeros(0), 0.0, 4, 0) == NO_EVIDENCE
    assert NULL.presence(NO_EVIDENCE) == 0.0
    impossible = evidence_of(np.array([-np.inf]), np.array([-np.inf]), 0.0, 4, 8)
    assert np.isfinite([impossible.name, impossible.said, impossible.standing]).all()


@pytest.mark.parametrize(
    ("params", "named"),
    [
        ((0.0, 1.0, 1.0, 1.0, 0.0), "temperature"),
        ((0.1, -1.0, 1.0, 1.0, 0.0), "name"),
        ((0.1, 1.0, float("nan"), 1.0, 0.0), "said"),
        ((0.1, 1.0, 1.0, -0.1, 0.0), "standing"),
        ((0.1, 1.0, 1.0, 1.0, float("inf")), "bias"),
    ],
)
def test_impossible_parameters_are_refused(params, named):
    with pytest.raises(ValueError, match=named):
        NullParams(*params)
