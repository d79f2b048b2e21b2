"""What measures of calibration must obey whatever the numbers."""

import numpy as np

# Imported late by what is tested, which would make its first example slow.
import scipy.optimize
import scipy.stats  # noqa: F401
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from sceneq_core.evaluation.gate_decisions import Decisions, f1_of
from sceneq_core.evaluation.gate_tuning import tune_gate
from sceneq_core.evaluation.ranking import auroc
from sceneq_core.evaluation.reliability import (
    calibration_error,
    equal_mass_bins,
    equal_width_bins,
)
from sceneq_core.evaluation.risk_coverage import risk_coverage
from sceneq_core.evaluation.temperature import fit_temperature
from sceneq_core.routing.gate import Confidence, Gate, GateParams, log_softmax, softmax

unit = st.floats(0, 1)
counts = st.integers(1, 40)


@st.composite
def guesses(draw):
    n = draw(counts)
    confidence = draw(arrays.arrays(np.float64, n, elements=unit))
    return confidence, draw(arrays.arrays(np.bool_, n))


@st.composite
def decisions(draw):
    n = draw(st.integers(1, 12))
    columns = [draw(arrays.arrays(np.float64, n, elements=unit)) for _ in range(3)]
    return Decisions(*columns, draw(arrays.arrays(np.bool_, n)))


@given(guesses(), st.integers(1, 20))
def test_every_guess_is_in_one_bin_and_the_error_is_bounded(guess, count):
    for make in (equal_width_bins, equal_mass_bins):
        bins = make(*guess, count)
        assert sum(one.count for one in bins) == len(guess[0])
        assert len(bins) <= count
        assert all(one.low - 1e-12 <= one.confidence <= one.high + 1e-12 for one in bins)
        assert 0 <= calibration_error(bins) <= 1


@given(guesses())
def test_one_bin_compares_mean_confidence_with_accuracy(guess):
    gap = abs(guess[0].mean() - guess[1].mean())
    assert np.isclose(calibration_error(equal_width_bins(*guess, 1)), gap)
    assert np.isclose(calibration_error(equal_mass_bins(*guess, 1)), gap)


@given(guesses())
def test_the_area_is_between_the_best_and_the_worst_order(guess):
    curve = risk_coverage(*guess)
    worst = risk_coverage(1.0 - guess[1], guess[1])
    assert curve.least_area - 1e-12 <= curve.area <= worst.area + 1e-12
    assert np.isclose(curve.risk[-1], 1 - guess[1].mean())


@given(guesses())
def test_a_perfect_order_has_the_least_area_and_a_growing_risk(guess):
    curve = risk_coverage(guess[1].astype(float), guess[1])
    assert np.isclose(curve.excess_area, 0)
    assert (np.diff(curve.risk) >= -1e-12).all()


@given(guesses())
def test_ranking_measures_see_the_order_only(guess):
    score, right = np.round(guess[0], 3), guess[1]
    assert auroc(score, right) == auroc(3 * score + 1, right)
    assert risk_coverage(score, right).area == risk_coverage(3 * score + 1, right).area
    value, turned = auroc(score, right), auroc(-score, right)
    assert (value is None) == (len(set(right.tolist())) == 1)
    assert value is None or (0 <= value <= 1 and np.isclose(value + turned, 1))


@given(decisions())
def test_many_decisions_are_those_made_one_by_one(many):
    gate = GateParams()
    one_by_one = [
        Gate(gate).accepts(Confidence(*measures, 1.0))
        for measures in zip(many.p_max, many.margin, many.entropy_norm, strict=True)
    ]
    assert many.accepted(gate).tolist() == one_by_one


@given(decisions())
def test_tuning_never_makes_it_worse(many):
    tuned = f1_of(many.accepted(tune_gate(many, GateParams(), steps=4)), many.right)
    assert tuned.f1 >= f1_of(many.accepted(GateParams()), many.right).f1
    everything = f1_of(np.ones(len(many), bool), many.right)
    assert tuned.f1 >= everything.f1


def test_the_error_of_calibrated_guesses_tends_to_zero():
    rng = np.random.default_rng(5)
    errors = []
    for n in (100, 1_000, 100_000):
        confidence = rng.random(n)
        right = rng.random(n) < confidence
        errors.append(calibration_error(equal_width_bins(confidence, right, 15)))
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 0.01


def test_the_fitted_temperature_is_the_one_that_made_the_data():
    rng = np.random.default_rng(7)
    scores = rng.normal(0.2, 0.08, (4000, 30))
    for true in (0.02, 0.033, 0.1):
        p = softmax(scores, true)
        label = (p.cumsum(axis=1) < rng.random((len(p), 1))).sum(axis=1).clip(0, 29)
        rows = np.arange(len(p))

        def loss(t, label=label, rows=rows):
            return -float(log_softmax(scores / t)[rows, label].mean())

        assert abs(fit_temperature(loss) / true - 1) < 0.05
