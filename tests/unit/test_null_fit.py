"""The parameters of "none of them" from questions whose answer is known."""

import numpy as np
import pytest

from sceneq_core.evaluation.null_fit import fit_logistic, fit_null
from sceneq_core.routing.null import Evidence

RNG = np.random.default_rng(4)
SEEN = RNG.normal(0.5, 2.0, (4_000, 3))
PRESENT = RNG.random(len(SEEN)) < 1 / (1 + np.exp(-(SEEN @ [1.5, 0.5, 0.0] - 0.8)))


def test_known_parameters_are_found_again():
    weights, _ = fit_logistic(SEEN, PRESENT)
    assert weights == pytest.approx([1.5, 0.5, 0.0, -0.8], abs=0.15)


def test_the_temperature_is_the_one_whose_evidence_says_most():
    rows, present = SEEN[:1_000], PRESENT[:1_000]
    noise = RNG.normal(0.0, 3.0, rows.shape)

    def evidence_at(temperature: float) -> list[Evidence]:
        seen = rows + noise * abs(np.log(temperature / 0.05))
        return [Evidence(*row) for row in seen.tolist()]

    fitted = fit_null(evidence_at, present)
    assert fitted.temperature == pytest.approx(0.05, rel=0.1)
    found = [fitted.name, fitted.said, fitted.standing, fitted.bias]
    assert found == pytest.approx([1.5, 0.5, 0.0, -0.8], abs=0.3)


def test_a_few_questions_without_a_mistake_do_not_make_it_infinitely_sure():
    seen = np.array([[2.0], [3.0], [4.0], [-2.0], [-3.0]])
    (scale, bias), _ = fit_logistic(seen, seen[:, 0] > 0)
    p = 1 / (1 + np.exp(-(bias + scale * seen[:, 0])))
    assert 0.7 < p[0] < p[2] < 0.99
    assert 0.01 < p[4] < p[3] < 0.35


def test_a_question_may_count_as_much_as_several():
    rows, present = SEEN[:60], PRESENT[:60]
    counts = 1.0 + np.arange(60) % 3
    often = np.repeat(np.arange(60), counts.astype(int))
    weights, loss = fit_logistic(rows, present, counts)
    expected, expected_loss = fit_logistic(rows[often], present[often])
    assert weights == pytest.approx(expected, abs=1e-3)
    assert loss == pytest.approx(expected_loss)


def test_evidence_that_misleads_is_not_used():
    weights, _ = fit_logistic(-SEEN, PRESENT)
    assert weights[:2].tolist() == [0.0, 0.0]


def test_what_cannot_be_fitted_is_said():
    with pytest.raises(ValueError, match="3 of 3, nothing to tell apart"):
        fit_logistic(np.zeros((3, 1)), np.ones(3, np.bool_))
    with pytest.raises(ValueError, match="present: 2 values for 3 questions"):
        fit_logistic(np.zeros((3, 1)), np.ones(2, np.bool_))
