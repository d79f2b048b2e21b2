"""Whatever the sureness, a distribution stays one and keeps its order."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.routing.gate import softmax
from sceneq_core.routing.sureness import Sureness

distributions = st.lists(st.floats(-15, 15), min_size=2, max_size=12).map(
    lambda scores: softmax(np.array(scores), 1.0)
)
surenesses = st.builds(Sureness, st.floats(0, 8), st.floats(-10, 10))


@given(distributions, surenesses)
def test_it_adds_up_to_one_in_the_same_order(p, sureness):
    changed = sureness.of(p)
    assert changed.sum() == pytest.approx(1.0)
    assert (changed >= 0.0).all()
    above = p[:, None] > p
    assert (changed[:, None] >= changed - 1e-9)[above].all()


@given(distributions)
def test_the_usual_sureness_changes_nothing(p):
    assert Sureness().of(p) == pytest.approx(p, abs=1e-8)


@given(distributions, surenesses, st.floats(0, 5))
def test_a_higher_shift_never_makes_the_first_guess_less_sure(p, sureness, more):
    surer = Sureness(sureness.slope, sureness.shift + more)
    assert surer.of(p).max() >= sureness.of(p).max() - 1e-12
