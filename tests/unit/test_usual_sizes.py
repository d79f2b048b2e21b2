"""How large things usually are, and what that says of a name."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.encoding.joint import CLASSES, dimensions, given_evidence
from sceneq_core.encoding.usual_sizes import MOST, UsualSizes, learn_sizes, shape_of, sized

SOFA, MUG = shape_of((1.9, 0.8), 0.8, 0.0), shape_of((0.09, 0.08), 0.1, 0.75)
NAMES = ("coffee mug", "sofa", "unicorn")
LENGTHS = st.floats(0.0, 10.0)


def usual():
    again = [shape_of((2.1, 0.9), 0.9, 0.0), shape_of((1.7, 0.8), 0.7, 0.0)]
    examples = [("sofa", SOFA), *(("sofa", one) for one in again), ("coffee mug", MUG)]
    return learn_sizes(NAMES, examples)


def test_a_shape_is_the_logarithms_of_the_sides_and_the_height_above_the_floor():
    shape = shape_of((0.5, 2.0), 0.01, 1.2)
    assert shape == pytest.approx([np.log(2.0), np.log(0.5), np.log(0.03), 1.2])


def test_a_thing_as_long_as_a_sofa_is_a_sofa_rather_than_a_mug():
    mug, sofa, unicorn = usual().evidence(SOFA)
    assert sofa > 0 > mug
    assert mug == -MOST
    assert unicorn == 0.0


def test_what_is_shorter_than_usual_counts_half_as_far_as_what_is_longer():
    names = UsualSizes(np.zeros((2, 4)), np.array([[0.25] * 4, [0.5] * 4]))
    part, larger = (names.evidence(np.array([log, 0, 0, 0])) for log in (-0.6, 0.3))
    assert part == pytest.approx(larger)
    lower, higher = (names.evidence(np.array([0, 0, 0, metres])) for metres in (-0.3, 0.3))
    assert lower == pytest.approx(higher)  # where it stands is no length
    assert names.evidence(np.zeros(4))[0] > part[0] > names.evidence(np.array([0.6, 0, 0, 0]))[0]


def test_names_that_were_never_measured_say_nothing():
    nothing = learn_sizes(NAMES, [])
    assert nothing.evidence(SOFA).tolist() == [0.0, 0.0, 0.0]


@given(LENGTHS, LENGTHS, LENGTHS, st.floats(-3.0, 10.0))
def test_evidence_has_limits_for_any_shape(long, short, height, underside):
    evidence = usual().evidence(shape_of((long, short), height, underside))
    assert np.isfinite(evidence).all()
    assert np.abs(evidence).max() <= MOST


def test_one_thing_that_was_measured_does_not_fix_the_size_of_all():
    spread = usual().spread
    assert (spread[0] > 0.1).all()
    assert np.isinf(spread[2]).all()


def test_bad_tables_are_refused():
    with pytest.raises(ValueError, match="sizes: mean"):
        UsualSizes(np.zeros((2, 3)), np.ones((2, 3)))
    with pytest.raises(ValueError, match="spread not positive"):
        UsualSizes(np.zeros((1, 4)), np.zeros((1, 4)))


@given(st.lists(st.floats(-3, 3), min_size=3, max_size=3))
def test_evidence_moves_what_the_probe_said_and_keeps_the_length(evidence):
    vector = np.zeros(dimensions(3), np.float32)
    vector[CLASSES : CLASSES + 3] = np.sqrt([0.5, 0.3, 0.1])
    vector[0] = np.sqrt(0.1)
    moved = given_evidence(vector, np.array(evidence))
    assert np.linalg.norm(moved) == pytest.approx(1.0, abs=1e-5)
    assert moved[0] == vector[0]
    odds = (moved[CLASSES] / moved[CLASSES + 1]) ** 2
    assert odds == pytest.approx(5 / 3 * np.exp(evidence[0] - evidence[1]), rel=1e-4)


def test_an_encoder_that_knows_no_sizes_leaves_descriptors_alone():
    descriptor = np.ones(3, np.float32)
    assert sized(object(), descriptor, SOFA) is descriptor
