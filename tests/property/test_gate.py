"""The gate is monotone: a surer guess is never refused where a less sure one passes."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.routing.gate import Confidence, Gate, GateParams, capped, softmax

unit = st.floats(0.0, 1.0)
confidences = st.builds(Confidence, unit, unit, unit, st.just(1.0))
gates = st.builds(lambda a, b, c, d: Gate(GateParams(a, b, c, d)), unit, unit, unit, unit)
scores = st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=30).map(np.array)


@given(gates, confidences, unit, unit, unit)
def test_more_confidence_never_closes_the_gate(gate, confidence, more_p, more_margin, less_entropy):
    surer = Confidence(
        min(1.0, confidence.p_max + more_p),
        min(1.0, confidence.margin + more_margin),
        max(0.0, confidence.entropy_norm - less_entropy),
        1.0,
    )
    assert gate.accepts(surer) >= gate.accepts(confidence)


@given(scores, st.floats(0.01, 10.0))
def test_softmax_is_a_distribution_that_keeps_the_order(values, temperature):
    p = softmax(values, temperature)
    assert np.isclose(p.sum(), 1.0)
    assert (p >= 0).all()
    assert p[np.argmax(values)] == p.max()


@given(scores, st.floats(0.01, 1.0), st.floats(1.0, 10.0))
def test_a_lower_temperature_is_more_confident(values, temperature, factor):
    cold = Confidence.of(softmax(values, temperature), temperature)
    warm = Confidence.of(softmax(values, temperature * factor), temperature)
    assert cold.p_max >= warm.p_max - 1e-12
    assert cold.entropy_norm <= warm.entropy_norm + 1e-9


@given(scores, st.randoms(use_true_random=False))
def test_confidence_does_not_depend_on_the_order_of_choices(values, random):
    shuffled = list(values)
    random.shuffle(shuffled)
    one = Confidence.of(softmax(values, 0.1), 0.1)
    other = Confidence.of(softmax(np.array(shuffled), 0.1), 0.1)
    assert np.isclose(one.p_max, other.p_max)
    assert np.isclose(one.margin, other.margin)
    assert np.isclose(one.entropy_norm, other.entropy_norm)


@given(scores, st.floats(0.01, 1.0), st.floats(0.05, 1.0))
def test_nothing_is_surer_than_the_ceiling_and_the_order_stays(values, temperature, ceiling):
    p = softmax(values, temperature)
    lower = capped(p, ceiling)
    assert np.isclose(lower.sum(), 1.0)
    assert lower.max() <= max(ceiling, 1 / len(p)) + 1e-12
    assert (np.diff(lower[np.argsort(p, kind="stable")]) >= -1e-12).all()
    if p.max() <= ceiling:
        assert np.array_equal(lower, p)
