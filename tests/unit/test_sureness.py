"""How sure a first guess is, computed by hand and fitted to what made the data."""

import numpy as np
import pytest

from sceneq_core.evaluation.sureness_fit import fit_sureness
from sceneq_core.routing.sureness import Sureness


def test_odds_of_the_first_guess_change_and_the_rest_keeps_its_proportions():
    p = Sureness(slope=2.0, shift=0.0).of(np.array([0.1, 0.6, 0.3]))
    # odds 0.6 / 0.4 squared = 2.25
    assert p == pytest.approx([0.25 * 4 / 13, 9 / 13, 0.75 * 4 / 13])
    doubled = Sureness(shift=float(np.log(2.0))).of(np.array([0.5, 0.25, 0.25]))
    assert doubled == pytest.approx([2 / 3, 1 / 6, 1 / 6])


def test_the_first_guess_never_falls_behind_the_second():
    p = Sureness(shift=-5.0).of(np.array([0.5, 0.4, 0.1]))
    assert p == pytest.approx(np.array([4, 4, 1]) / 9)


@pytest.mark.parametrize("p", [[], [1.0], [0.0]])
def test_without_a_second_choice_nothing_changes(p):
    assert Sureness(3.0, 1.0).of(np.array(p)).tolist() == p


@pytest.mark.parametrize(("slope", "shift"), [(-0.1, 0.0), (float("nan"), 0.0), (1.0, 1e9)])
def test_impossible_parameters_are_refused(slope, shift):
    with pytest.raises(ValueError, match=r"slope|shift"):
        Sureness(slope, shift)


def test_the_fit_finds_what_made_the_data():
    random = np.random.default_rng(0)
    p_max = random.uniform(0.05, 0.95, 4000)
    truth = 1 / (1 + np.exp(-(0.6 * np.log(p_max / (1 - p_max)) - 0.8)))
    fitted = fit_sureness(p_max, random.random(4000) < truth)
    assert (fitted.slope, fitted.shift) == pytest.approx((0.6, -0.8), abs=0.1)


def test_guesses_that_are_all_alike_tell_nothing():
    assert fit_sureness(np.array([0.2, 0.9]), np.array([True, True])) == Sureness()
    assert fit_sureness(np.zeros(0), np.zeros(0, np.bool_)) == Sureness()
    with pytest.raises(ValueError, match="1 values for 2 guesses"):
        fit_sureness(np.array([0.2, 0.9]), np.array([True]))


def test_few_guesses_that_can_be_told_apart_do_not_make_it_infinitely_sure():
    fitted = fit_sureness(np.array([0.1, 0.2, 0.8, 0.9]), np.array([False, False, True, True]))
    assert 0.0 < fitted.slope < 2.0
    assert fitted.shift == pytest.approx(0.0, abs=0.01)
