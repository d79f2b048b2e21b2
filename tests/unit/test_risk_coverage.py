"""Risk at each coverage and the area under it, computed by hand."""

import numpy as np
import pytest

from sceneq_core.evaluation.risk_coverage import risk_coverage


def test_the_surest_come_first():
    curve = risk_coverage(np.array([0.2, 0.9, 0.6, 0.4]), np.array([True, True, False, True]))
    assert curve.coverage.tolist() == [0.25, 0.5, 0.75, 1.0]
    assert curve.risk == pytest.approx([0.0, 1 / 2, 1 / 3, 1 / 4])
    assert curve.area == pytest.approx((0 + 1 / 2 + 1 / 3 + 1 / 4) / 4)


def test_the_best_order_has_the_wrong_ones_last():
    curve = risk_coverage(np.array([0.2, 0.9, 0.6, 0.4]), np.array([True, True, False, True]))
    assert curve.least_area == pytest.approx((1 / 4) / 4)
    assert curve.excess_area == pytest.approx((1 / 2 + 1 / 3) / 4)


def test_equally_sure_ones_count_as_their_mean():
    curve = risk_coverage(np.array([0.5, 0.5, 0.1]), np.array([True, False, False]))
    assert curve.risk == pytest.approx([0.5, 0.5, 2 / 3])


def test_all_right_and_nothing_have_no_risk():
    assert risk_coverage(np.array([0.3, 0.2]), np.array([True, True])).area == 0.0
    nothing = risk_coverage(np.zeros(0), np.zeros(0, bool))
    assert (nothing.area, nothing.least_area) == (0.0, 0.0)


def test_lengths_must_agree():
    with pytest.raises(ValueError, match="right: 1 values for 2"):
        risk_coverage(np.array([0.3, 0.2]), np.array([True]))
