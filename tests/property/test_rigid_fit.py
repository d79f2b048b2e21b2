"""The motion that most pairs agree on is found, whatever the others say."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_core.ingest.transforms import angle_deg, transform
from sceneq_core.places.rigid_fit import FitParams, fit_rigid

from support.rigid import rigid

SEEDS = st.integers(0, 10_000)


@settings(max_examples=30, deadline=None)
@given(seed=SEEDS, false=st.integers(0, 30))
def test_false_pairs_do_not_matter(seed, false):
    rng = np.random.default_rng(seed)
    T_b_a = rigid(seed, reach_m=4.0)
    a = rng.uniform(-2, 2, (30 + false, 3))
    b = transform(T_b_a, a) + rng.normal(0, 0.003, a.shape)
    b[30:] += rng.uniform(0.5, 3.0, (false, 3)) * rng.choice([-1, 1], (false, 3))
    fit = fit_rigid(a, b, FitParams())
    assert fit is not None
    assert angle_deg(fit.T_b_a, T_b_a) < 0.5
    assert np.linalg.norm(transform(fit.T_b_a, a[:30]) - b[:30], axis=1).max() < 0.03
    assert fit.agrees[:30].all()
    assert not fit.agrees[30:].any()


@settings(max_examples=20, deadline=None)
@given(seed=SEEDS, count=st.integers(0, 2))
def test_two_pairs_are_not_enough(seed, count):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    assert fit_rigid(points, points, FitParams()) is None


@settings(max_examples=20, deadline=None)
@given(seed=SEEDS)
def test_the_answer_is_a_rotation_not_a_reflection(seed):
    rng = np.random.default_rng(seed)
    flat = rng.uniform(-1, 1, (12, 3)) * [1, 1, 0]
    fit = fit_rigid(flat, flat * [1, -1, 1], FitParams())
    assert fit is None or np.linalg.det(fit.T_b_a[:3, :3]) > 0.99
