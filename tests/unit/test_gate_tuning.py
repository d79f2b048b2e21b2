"""F1 of the gate's decisions, its sensitivity, and the thresholds with the best one."""

import numpy as np
import pytest

from sceneq_core.evaluation.gate_decisions import Decisions, f1_of, sensitivity
from sceneq_core.evaluation.gate_tuning import tune_gate
from sceneq_core.routing.gate import GateParams

RIGHT = np.array([True, True, True, False, False])
FIVE = Decisions(
    p_max=np.array([0.9, 0.8, 0.4, 0.3, 0.7]),
    margin=np.array([0.8, 0.3, 0.2, 0.1, 0.1]),
    entropy_norm=np.array([0.1, 0.4, 0.6, 0.9, 0.3]),
    right=RIGHT,
)


def test_f1_by_hand():
    score = f1_of(np.array([True, False, True, True, False]), RIGHT)
    assert (score.precision, score.recall) == (2 / 3, 2 / 3)
    assert score.f1 == pytest.approx(2 / 3)
    assert score.accepted == pytest.approx(3 / 5)


def test_f1_of_nothing_is_zero():
    none = np.zeros(5, bool)
    assert f1_of(none, RIGHT).f1 == f1_of(none, none).f1 == f1_of(none[:0], none[:0]).f1 == 0.0


def test_no_threshold_falls_below_what_may_be_claimed():
    free, bound = tune_gate(FIVE, GateParams()), tune_gate(FIVE, GateParams(), least_p=0.6)
    assert free.min_p < 0.6 <= bound.min_p
    assert FIVE.accepted(bound).tolist()[:2] == [True, True]


def test_the_gate_decides_as_it_does_for_one():
    # The first is sure; the second has a clear margin; the last has too small a margin.
    assert FIVE.accepted(GateParams()).tolist() == [True, True, False, False, False]


def test_columns_must_be_equally_long():
    with pytest.raises(ValueError, match="length"):
        Decisions(FIVE.p_max, FIVE.margin, FIVE.entropy_norm, RIGHT[:2])


def test_tuning_separates_what_can_be_separated():
    gate = tune_gate(FIVE, GateParams())
    assert f1_of(FIVE.accepted(gate), RIGHT).f1 == 1.0
    # One threshold had to move; those that need not have stayed.
    assert gate == GateParams(min_p=0.35)


def test_without_anything_right_the_thresholds_stay():
    wrong = Decisions(FIVE.p_max, FIVE.margin, FIVE.entropy_norm, np.zeros(5, bool))
    assert tune_gate(wrong, GateParams(min_p=0.3)) == GateParams(min_p=0.3)


def test_one_guess_that_is_right_is_let_through():
    one = Decisions(np.array([0.1]), np.array([0.01]), np.array([0.99]), np.array([True]))
    assert one.accepted(tune_gate(one, GateParams())).tolist() == [True]


def test_sensitivity_scales_one_threshold_at_a_time():
    table = sensitivity(FIVE, GateParams(min_p=0.42, min_margin=0.15, clear_margin=0.2))
    assert [(row.threshold, row.factor) for row in table[:3]] == [
        ("min_p", 0.9), ("min_p", 1.0), ("min_p", 1.1),
    ]  # fmt: skip
    assert len(table) == 12
    # 0.378 lets the third one in, which is right; 0.42 and 0.462 do not.
    assert [row.score.f1 for row in table[:3]] == pytest.approx([1.0, 0.8, 0.8])
    assert max(row.value for row in sensitivity(FIVE, GateParams(min_p=1.0))) == 1.0
