"""Votes of a model beside the probabilities of the encoder."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.reasoning.vote import instance_shares, label_shares, ranked

PRIOR = np.array([0.5, 0.3, 0.1])


def test_the_majority_wins_whatever_the_encoder_says():
    assert ranked(label_shares([1, 2, 2], np.array([1.0, 0.0, 0.0]), 0.9))[0] == 2


def test_a_tie_goes_to_whom_the_encoder_ranks_first():
    assert ranked(label_shares([2, 1], PRIOR, 0.5))[:2] == [1, 2]
    assert ranked(label_shares([0, 1], np.array([0.4, 0.4]), 0.5)) == [0, 1]


def test_more_votes_are_more_certain():
    once, thrice = (label_shares([0] * n, PRIOR, 0.5)[0] for n in (1, 3))
    assert once == pytest.approx((1 + 0.5 * 0.5 / 0.9) / 1.5)
    assert thrice == pytest.approx((3 + 0.5 * 0.5 / 0.9) / 3.5)


def test_without_votes_the_encoder_is_repeated():
    assert label_shares([], PRIOR, 0.5).tolist() == pytest.approx((PRIOR / 0.9).tolist())


def test_labels_without_any_probability_are_equal():
    assert label_shares([], np.zeros(4), 0.5).tolist() == [0.25] * 4


def test_none_of_them_wins_by_a_vote():
    shares = instance_shares([None], PRIOR, [True] * 3, 0.5)
    assert ranked(shares)[0] == 3
    assert shares[3] == pytest.approx((1 + 0.5 * 0.1) / 1.5)


def test_none_of_those_shown_may_be_one_that_was_not():
    shares = instance_shares([None], PRIOR, [False, True, True], 0.5)
    assert shares[0] == pytest.approx((0.5 / 0.6 + 0.5 * 0.5) / 1.5)
    assert ranked(shares)[0] == 0


def test_none_without_any_doubt_before_is_still_none():
    shares = instance_shares([None], np.array([1.0]), [True], 0.5)
    assert shares.tolist() == pytest.approx([1 / 3, 2 / 3])


@given(
    st.lists(st.one_of(st.none(), st.integers(0, 3)), max_size=7),
    st.lists(st.floats(0, 0.25), min_size=4, max_size=4),
    st.lists(st.booleans(), min_size=4, max_size=4),
    st.floats(0.01, 0.99),
)
def test_shares_are_probabilities_and_majorities_hold(votes, prior, shown, prior_votes):
    shares = instance_shares(votes, np.array(prior), shown, prior_votes)
    assert shares.min() >= 0
    assert shares.sum() == pytest.approx(1.0)
    counts = [votes.count(row) for row in range(4)]
    best = max(range(4), key=counts.__getitem__)
    if counts[best] > len(votes) / 2 and votes.count(None) == 0:
        assert ranked(shares)[0] == best
