"""Log loss and Brier scores, computed by hand."""

import numpy as np
import pytest

from sceneq_core.evaluation.proper_scores import LEAST_P, brier, log_loss, top_brier

P = np.array([0.5, 0.3, 0.2])


def truth(*rows):
    return np.isin(np.arange(3), rows)


def test_log_loss_of_one_right_class():
    assert log_loss(P, truth(1)) == pytest.approx(1.2039728)


def test_several_right_classes_count_as_one():
    assert log_loss(P, truth(1, 2)) == pytest.approx(np.log(2))
    assert brier(P, truth(1, 2)) == pytest.approx(0.5**2 + 0.5**2)


def test_an_impossible_truth_costs_a_bounded_amount():
    assert log_loss(np.array([1.0, 0.0]), np.array([False, True])) == -np.log(LEAST_P)


def test_brier_of_one_right_class():
    assert brier(P, truth(0)) == pytest.approx(0.5**2 + 0.3**2 + 0.2**2)
    assert brier(np.array([0.0, 1.0]), np.array([False, True])) == 0.0
    assert brier(np.array([1.0, 0.0]), np.array([False, True])) == 2.0


def test_brier_of_the_first_guess():
    right = np.array([True, False])
    assert top_brier(np.array([0.8, 0.4]), right) == pytest.approx((0.04 + 0.16) / 2)
    assert top_brier(np.zeros(0), np.zeros(0, bool)) == 0.0
