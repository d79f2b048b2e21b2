"""Telling familiar scenes from strange ones, and how sure names may be in either."""

import numpy as np
import pytest

from sceneq_core.evaluation.familiarity_fit import (
    LEAST_VARIANCE,
    fit_familiarity,
    fit_label_ceiling,
)
from sceneq_core.routing.unfamiliar import Unfamiliar

KNOWN, STRANGE = np.array([0.85, 0.87, 0.89, 0.91]), np.array([0.70, 0.72, 0.74])


def test_the_middle_is_halfway_and_the_slope_is_of_the_pooled_variance():
    middle, slope = fit_familiarity(KNOWN, STRANGE)
    assert middle == pytest.approx((0.88 + 0.72) / 2)
    variance = (0.0005 + 0.0008 / 3) / 2  # of both populations
    assert slope == pytest.approx((0.88 - 0.72) / variance)


def test_both_kinds_count_alike_however_many_there_are():
    many = np.tile(STRANGE, 50)
    assert fit_familiarity(KNOWN, many) == pytest.approx(fit_familiarity(KNOWN, STRANGE))


def test_scenes_that_are_all_alike_do_not_decide_infinitely_sharply():
    middle, slope = fit_familiarity(np.array([0.9]), np.array([0.7]))
    assert (middle, slope) == (pytest.approx(0.8), pytest.approx(0.2 / LEAST_VARIANCE))
    assert Unfamiliar(0.1, middle, slope).share(0.8) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("known", "strange", "complaint"),
    [
        (KNOWN, np.zeros(0), "4 known scenes and 0 strange"),
        (np.zeros(0), STRANGE, "0 known scenes and 3 strange"),
        (STRANGE, KNOWN, "0.720 of known scenes, 0.880 of strange"),
        (KNOWN, KNOWN, "0.880 of known scenes, 0.880"),
    ],
)
def test_what_tells_nothing_is_refused(known, strange, complaint):
    with pytest.raises(ValueError, match=complaint):
        fit_familiarity(known, strange)


def test_the_ceiling_is_the_share_of_right_names_at_a_familiarity():
    seen = np.repeat([0.5, 0.9], 10)
    right = np.isin(np.arange(20), [0, 1, 2, *range(10, 18)])  # three of ten, eight of ten
    ceiling = fit_label_ceiling(seen, right, np.ones(20))
    assert ceiling is not None
    assert [ceiling.at(0.5), ceiling.at(0.9)] == pytest.approx([0.3, 0.8], abs=1e-3)
    twice = fit_label_ceiling(seen, right, np.where(right & (seen < 0.7), 2.0, 1.0))
    assert twice is not None
    assert twice.at(0.5) == pytest.approx(6 / 13, abs=1e-3)


def test_names_that_are_all_right_or_all_wrong_tell_no_ceiling():
    for value in (True, False):
        assert fit_label_ceiling(np.arange(3.0), np.full(3, value), np.ones(3)) is None
