"""Telling familiar scenes from strange ones, and how sure names may be in either."""

import numpy as np
import pytest

from sceneq_core.evaluation.familiarity_fit import (
    LEAST_VARIANCE,
    fit_familiarity,
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
