"""Faultless and wrong probabilities, told apart by what chance can do."""

import numpy as np
import pytest

from sceneq_core.evaluation.reliability import (
    Bin,
    calibration_error,
    equal_mass_bins,
    equal_width_bins,
)
from sceneq_core.evaluation.verified_error import (
    as_much_by_chance,
    debiased_error,
    debiased_square,
    error_interval,
    errors_without_fault,
)

P = np.random.default_rng(1).random(2_000)
NOTHING = np.zeros(0), np.zeros(0, np.bool_)


def happened(p, seed, too_sure=0.0):
    return np.random.default_rng(100 + seed).random(len(p)) < p - too_sure


def test_even_faultless_probabilities_show_an_error_that_shrinks_with_their_number():
    few, many = (errors_without_fault(some, 15).mean() for some in (P[:30], P))
    assert 0.1 < few < 0.3
    assert 0.01 < many < 0.04
    assert errors_without_fault(np.array([0.0, 1.0]), 15).max() == 0.0
    assert errors_without_fault(np.array([0.5]), 1).mean() == 0.5
    assert np.array_equal(errors_without_fault(P[:30], 15), errors_without_fault(P[:30], 15))


def test_the_errors_without_fault_are_those_of_the_bins():
    right = np.random.default_rng(0).random((1, 30)) < P[:30]
    shown = calibration_error(equal_width_bins(P[:30], right[0], 15))
    assert errors_without_fault(P[:30], 15, rounds=1)[0] == pytest.approx(shown)


def test_faultless_probabilities_are_as_good_as_chance_and_wrong_ones_are_not():
    some = P[:300]
    faultless = [as_much_by_chance(some, happened(some, seed), 15) for seed in range(40)]
    assert 0.35 < np.mean(faultless) < 0.65
    assert as_much_by_chance(some, happened(some, 0, too_sure=0.25), 15) < 0.01
    assert as_much_by_chance(*NOTHING, 15) == 1.0


@pytest.mark.parametrize("too_sure", [0.0, 0.2])
def test_without_its_bias_the_square_is_right_on_average(too_sure):
    p = 0.3 + 0.6 * P[:100]
    bins = [equal_mass_bins(p, happened(p, seed, too_sure), 10) for seed in range(150)]
    assert np.mean([debiased_square(one) for one in bins]) == pytest.approx(too_sure**2, abs=0.006)
    assert np.mean([calibration_error(one) for one in bins]) > too_sure + 0.01  # it has a bias


def test_the_square_by_hand():
    bins = (Bin(0.0, 0.5, 4, 0.25, 0.5), Bin(0.5, 0.8, 2, 0.7, 1.0), Bin(0.8, 1.0, 1, 0.9, 0.0))
    expected = (4 * (0.25**2 - 0.25 / 3) + 2 * 0.3**2) / 6  # the last one tells nothing
    assert debiased_square(bins) == pytest.approx(expected)
    assert debiased_error(bins[1:]) == pytest.approx(0.3)
    assert debiased_error(bins[:1]) == 0.0
    assert debiased_square(bins[2:]) == debiased_square(()) == 0.0


@pytest.mark.parametrize("too_sure", [0.1, 0.25])
def test_the_interval_holds_the_true_error_as_often_as_it_says(too_sure):
    p = 0.3 + 0.7 * P[:300]
    found = [error_interval(p, happened(p, seed, too_sure), 15) for seed in range(30)]
    held = [low <= too_sure <= high for low, high in found]
    assert 0.75 <= np.mean(held) <= 1.0
    assert all(0.0 <= low <= high <= 1.0 for low, high in found)


def test_the_interval_of_faultless_probabilities_goes_down_to_almost_nothing():
    lows = [error_interval(P[:300], happened(P[:300], seed), 15)[0] for seed in range(20)]
    assert np.mean(lows) < 0.02
    assert error_interval(*NOTHING, 15) == (0.0, 1.0)
