"""Bins and expected calibration error, computed by hand."""

import numpy as np
import pytest

from sceneq_core.evaluation.reliability import (
    Bin,
    calibration_error,
    equal_mass_bins,
    equal_width_bins,
)

SURE = np.array([0.0, 0.5, 0.51, 1.0])
RIGHT = np.array([False, True, False, True])


def test_equal_width_bins_are_open_below_and_closed_above():
    low, high = equal_width_bins(SURE, RIGHT, 2)
    assert (low.low, low.high, low.count) == (0.0, 0.5, 2)  # 0 belongs to the first, 0.5 as well
    assert (high.low, high.high, high.count) == (0.5, 1.0, 2)
    assert (low.confidence, low.accuracy) == (0.25, 0.5)
    assert (high.confidence, high.accuracy) == (0.755, 0.5)


def test_the_error_weighs_each_gap_by_its_count():
    bins = (Bin(0.0, 0.5, 3, 0.25, 0.5), Bin(0.5, 1.0, 1, 0.9, 0.0))
    assert calibration_error(bins) == pytest.approx((3 * 0.25 + 1 * 0.9) / 4)


def test_empty_bins_are_left_out_and_nothing_has_no_error():
    assert [one.count for one in equal_width_bins(SURE[3:], RIGHT[3:], 10)] == [1]
    nothing = np.zeros(0)
    assert equal_mass_bins(nothing, nothing.astype(bool), 5) == ()
    assert calibration_error(equal_width_bins(nothing, nothing.astype(bool), 5)) == 0.0


def test_bins_of_equal_mass_hold_equally_many():
    confidence = np.array([0.9, 0.1, 0.2, 0.3, 0.4, 0.8])
    right = np.array([True, False, False, True, True, True])
    bins = equal_mass_bins(confidence, right, 3)
    assert [(one.low, one.high, one.count) for one in bins] == [
        (0.0, 0.2, 2), (0.2, 0.4, 2), (0.4, 0.9, 2),
    ]  # fmt: skip
    assert [one.accuracy for one in bins] == [0.0, 1.0, 1.0]
    # |0 - 0.15|, |1 - 0.35|, |1 - 0.85|, each of two of six
    assert calibration_error(bins) == pytest.approx((0.15 + 0.65 + 0.15) / 3)


def test_ties_share_a_bin_of_equal_mass():
    confidence = np.array([0.3, 0.3, 0.3, 0.3, 0.7, 0.8])
    right = np.array([True, False, False, True, True, False])
    bins = equal_mass_bins(confidence, right, 3)
    assert [one.count for one in bins] == [4, 2]
    order = np.array([3, 1, 5, 0, 4, 2])
    assert equal_mass_bins(confidence[order], right[order], 3) == bins


@pytest.mark.parametrize("make", [equal_width_bins, equal_mass_bins])
@pytest.mark.parametrize(
    ("confidence", "right", "count", "field"),
    [
        ([0.5], [True, False], 5, "right"),
        ([0.5], [True], 0, "count"),
        ([1.5], [True], 5, "confidence"),
        ([float("nan")], [True], 5, "confidence"),
    ],
)
def test_bad_input_is_named(make, confidence, right, count, field):
    with pytest.raises(ValueError, match=field):
        make(np.array(confidence), np.array(right), count)
