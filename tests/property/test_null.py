"""More evidence never makes "none of them" likelier, and all probabilities add up to 1."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.routing.gate import Confidence, Gate, GateParams, softmax
from sceneq_core.routing.null import Evidence, NullParams, evidence_of

numbers = st.floats(-20, 20)
weights = st.floats(0, 10)
nulls = st.builds(NullParams, st.floats(0.01, 1), weights, weights, weights, numbers)
evidence = st.builds(Evidence, numbers, numbers, numbers)
scores = st.lists(numbers, min_size=1, max_size=12).map(np.array)


@given(nulls, evidence, st.sampled_from(["name", "said", "standing"]), st.floats(0, 20))
def test_more_evidence_of_any_kind_never_makes_it_less_present(null, seen, kind, more):
    surer = replace(seen, **{kind: getattr(seen, kind) + more})
    assert 0.0 <= null.presence(seen) <= null.presence(surer) + 1e-12 <= 1.0 + 1e-9


@given(st.lists(st.floats(1e-6, 1), min_size=1, max_size=10), st.floats(1e-6, 1))
def test_one_more_thing_of_the_name_takes_no_evidence_away(p, more):
    few, many = (np.log(x) for x in (p, [*p, more]))
    assert (
        evidence_of(many, np.zeros(len(many)), 0.5, 9, 20).name
        >= evidence_of(few, np.zeros(len(few)), 0.5, 9, 20).name
    )


@given(scores, st.floats(0.01, 1))
def test_all_choices_and_none_add_up_to_one(values, presence):
    p = presence * softmax(values, 1.0)
    confidence = Confidence.of(p, 1.0, 1.0 - presence)
    assert p.sum() + confidence.p_null == pytest.approx(1.0)
    assert confidence.p_max == pytest.approx(presence * softmax(values, 1.0).max())
    assert confidence.margin <= confidence.p_max - confidence.p_null + 1e-12
    assert 0.0 <= confidence.entropy_norm <= 1.0


@given(scores, st.floats(0, 1), st.floats(0, 1))
def test_the_gate_never_opens_because_absence_gets_likelier(values, one, other):
    gate, p = Gate(GateParams(max_entropy_norm=0.0)), softmax(values, 1.0)
    low, high = sorted((one, other))
    likelier = Confidence.of((1.0 - high) * p, 1.0, high)
    if gate.accepts(likelier):
        assert gate.accepts(Confidence.of((1.0 - low) * p, 1.0, low))
