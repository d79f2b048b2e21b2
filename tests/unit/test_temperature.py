"""The temperature with the least loss."""

import numpy as np
import pytest

from sceneq_core.evaluation.temperature import fit_temperature


def test_the_least_of_a_parabola_is_found():
    assert fit_temperature(lambda t: (np.log(t) - np.log(0.037)) ** 2) == pytest.approx(
        0.037, rel=1e-3
    )


def test_of_two_valleys_the_deeper_one_is_taken():
    def loss(t):
        return min(abs(np.log(t / 0.5)) + 0.2, abs(np.log(t / 0.01)))

    assert fit_temperature(loss) == pytest.approx(0.01, rel=1e-3)


def test_the_bounds_hold():
    assert fit_temperature(lambda t: -t, 0.01, 0.2) == pytest.approx(0.2, rel=1e-3)
    assert fit_temperature(lambda t: t, 0.01, 0.2) == pytest.approx(0.01, rel=1e-3)


@pytest.mark.parametrize("bounds", [(0.0, 1.0), (0.5, 0.5), (-1.0, 1.0)])
def test_bounds_must_be_positive_and_in_order(bounds):
    with pytest.raises(ValueError, match="lowest"):
        fit_temperature(lambda t: t, *bounds)


def test_a_loss_that_is_not_finite_is_refused():
    with pytest.raises(ValueError, match="loss"):
        fit_temperature(lambda t: float("nan"))
