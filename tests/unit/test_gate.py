"""The gate and what it looks at."""

import numpy as np
import pytest

from sceneq_core.routing.gate import Confidence, Gate, GateParams, entropy_norm, softmax

GATE = Gate(GateParams())


def test_softmax_of_equal_scores_is_uniform():
    assert softmax(np.zeros(4), 0.1) == pytest.approx([0.25] * 4)


def test_softmax_divides_by_the_temperature():
    assert softmax(np.array([0.0, 0.1 * np.log(3.0)]), 0.1) == pytest.approx([0.25, 0.75])


def test_softmax_of_large_scores_is_finite():
    assert softmax(np.array([1e6, 0.0]), 0.01).tolist() == [1.0, 0.0]


@pytest.mark.parametrize("temperature", [0.0, -1.0, float("nan")])
def test_softmax_refuses_a_temperature_that_is_not_positive(temperature):
    with pytest.raises(ValueError, match="temperature"):
        softmax(np.zeros(2), temperature)


def test_confidence_of_a_distribution():
    confidence = Confidence.of(np.array([0.1, 0.7, 0.2]), 0.05)
    assert confidence.p_max == pytest.approx(0.7)
    assert confidence.margin == pytest.approx(0.5)
    assert confidence.entropy_norm == pytest.approx(0.7298, abs=1e-4)
    assert confidence.temperature == 0.05


def test_one_choice_is_certain_and_no_choice_is_not():
    assert Confidence.of(np.array([1.0]), 1.0) == Confidence(1.0, 1.0, 0.0, 1.0)
    assert Confidence.of(np.zeros(0), 1.0) == Confidence(0.0, 0.0, 1.0, 1.0)


def test_none_of_them_is_one_more_choice():
    confidence = Confidence.of(np.array([0.4, 0.1]), 0.05, 0.5)
    assert (confidence.p_max, confidence.p_null) == (0.4, 0.5)
    assert confidence.margin == pytest.approx(-0.1)
    p = np.array([0.4, 0.1, 0.5])
    assert confidence.entropy_norm == pytest.approx(-(p * np.log(p)).sum() / np.log(3))


def test_entropy_ignores_impossible_choices():
    assert entropy_norm(np.array([1.0, 0.0, 0.0])) == 0.0
    assert entropy_norm(np.full(5, 0.2)) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("p_max", "margin", "entropy", "accepted"),
    [
        (0.50, 0.15, 0.35, True),
        (0.49, 0.30, 0.10, False),
        (0.60, 0.14, 0.10, False),
        (0.60, 0.15, 0.36, False),
        (0.60, 0.20, 0.90, True),
        (0.55, 0.19, 0.36, False),
    ],
)
def test_the_papers_thresholds(p_max, margin, entropy, accepted):
    assert GATE.accepts(Confidence(p_max, margin, entropy, 0.1)) is accepted


def test_thresholds_outside_the_unit_interval_are_refused():
    with pytest.raises(ValueError, match=r"min_margin: must be from 0 to 1, got 1\.5"):
        GateParams(min_margin=1.5)
