"""AUROC and Hit@k, computed by hand."""

import numpy as np
import pytest

from sceneq_core.evaluation.ranking import auroc, hit_at


def test_auroc_counts_pairs_in_order():
    # Pairs (positive, negative): (.8, .6) ahead, (.8, .1) ahead, (.4, .6) behind, (.4, .1) ahead.
    score = np.array([0.8, 0.6, 0.4, 0.1])
    assert auroc(score, np.array([True, False, True, False])) == pytest.approx(3 / 4)


def test_a_tie_is_half():
    assert auroc(np.array([0.5, 0.5]), np.array([True, False])) == 0.5
    tied = np.array([0.9, 0.5, 0.5, 0.1])
    assert auroc(tied, np.array([True, True, False, False])) == pytest.approx(3.5 / 4)


@pytest.mark.parametrize("positive", [[True, True], [False, False]])
def test_one_kind_alone_has_no_auroc(positive):
    assert auroc(np.array([0.3, 0.7]), np.array(positive)) is None


def test_auroc_needs_equal_lengths():
    with pytest.raises(ValueError, match="positive"):
        auroc(np.array([0.3, 0.7]), np.array([True]))


def test_hit_at_k_looks_at_the_first_k():
    assert not hit_at([7, 3, 5], {3}, 1)
    assert hit_at([7, 3, 5], {3}, 2)
    assert not hit_at([], {3}, 5)
    assert not hit_at([7], set(), 5)
