"""What several votes say about several choices.

Every vote counts one; before any vote the encoder's probabilities count ``prior_votes`` in all
(the mean of a Dirichlet posterior). With less than one prior vote the majority always wins and the
encoder decides ties: equal votes go to whom it ranked first.
"""

from collections.abc import Sequence

import numpy as np

from sceneq_core.arrays import Bool, Float64


def label_shares(votes: Sequence[int], prior: Float64, prior_votes: float) -> Float64:
    """Return probabilities (K,) of K choices that exclude each other, one of which is right.

    ``votes`` are rows of choices, ``prior`` (K,) what the encoder says, of any sum.
    """
    total = prior.sum()
    before = prior / total if total > 0 else np.full(len(prior), 1 / len(prior))
    return _mean(_counted(votes, len(prior)), before, prior_votes)


def instance_shares(
    votes: Sequence[int | None], prior: Float64, shown: Sequence[bool], prior_votes: float
) -> Float64:
    """Return probabilities (K + 1,) of K candidates and, last, of "none of them".

    ``votes`` are rows of candidates, ``None`` = none of those shown: that vote is shared by the
    candidates that were not ``shown`` and "none of them", as the encoder expects. ``prior`` (K,)
    sums to at most 1, what is missing is "none of them".
    """
    before = np.append(prior, max(0.0, 1.0 - prior.sum()))
    before /= before.sum()
    counts = _counted([vote for vote in votes if vote is not None], len(before))
    elsewhere = np.append(~np.asarray(shown, bool), True)
    counts += sum(vote is None for vote in votes) * _within(before, elsewhere)
    return _mean(counts, before, prior_votes)


def ranked(shares: Float64) -> list[int]:
    """Return the rows of choices, most probable first, equal ones in their order."""
    order: list[int] = np.argsort(-shares, kind="stable").tolist()
    return order


def _counted(votes: Sequence[int], count: int) -> Float64:
    return np.bincount(np.array(votes, np.int64), minlength=count).astype(np.float64)


def _within(before: Float64, among: Bool) -> Float64:
    """Return ``before`` over the rows ``among``, adding up to one; the last is always one of them.

    The last takes all when the encoder expects none of the others either.
    """
    part = np.where(among, before, 0.0)
    if not part.sum() > 0:
        part[-1] = 1.0
    return np.asarray(part / part.sum(), np.float64)


def _mean(counts: Float64, before: Float64, prior_votes: float) -> Float64:
    total = counts.sum() + prior_votes
    shares: Float64 = (counts + prior_votes * before) / total if total > 0 else before
    return shares
