"""Which group each superpoint fits best by now, and which superpoints disagree with theirs."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int32, Int64
from sceneq_core.mapping.agreement import RegionViews, expected_agreement
from sceneq_core.mapping.association_params import AssociationParams
from sceneq_core.mapping.coverage import NO_REGION
from sceneq_core.mapping.evidence import NO_SEGMENT


@dataclass(frozen=True, slots=True)
class _Fit:
    """How well superpoints fit one group each: ``score`` and ``agreement``, float64 (N,)."""

    score: Float64
    agreement: Float64


def consolidated(
    segment: Int32, group: Int32, owner: Int32, views: RegionViews, params: AssociationParams
) -> tuple[Int32, Bool]:
    """Return the group int32 (N,) that fits each superpoint best, and who agrees with none (N,).

    ``segment`` int32 (N, V) the evidence of the superpoints, ``group`` int32 (N,) where they are
    now, -1 = none; ``owner`` int32 (S,) the group that covers most of each segment.

    A group fits as its segments do: a view is a vote for the owner of the segment it shows. An
    object whose mask fell into pieces still owns each piece, so votes unite; but things glued
    from the first view on would own each other's segments for ever, and it is the agreement with
    the dominant segment that tells them apart.
    """
    seen = segment != NO_SEGMENT
    voted = np.where(seen, owner[segment], NO_REGION)
    own = ((voted == group[:, None]) & (voted != NO_REGION)).sum(axis=1)
    rival, rival_votes = _rivals(voted, group, own)
    present = _fit(own, seen, segment, group, views, params)
    other = _fit(rival_votes, seen, segment, rival, views, params)
    moving = other.score > np.maximum(params.min_score, present.score + params.hold)
    moving &= other.agreement >= params.tau_detach
    alone = ~moving & (present.agreement < params.tau_detach)
    return np.where(moving, rival, group).astype(np.int32), alone


def _fit(
    votes: Int64,
    seen: Bool,
    segment: Int32,
    group: Int32,
    views: RegionViews,
    params: AssociationParams,
) -> _Fit:
    agreement = expected_agreement(*views.compare_segments(segment, group))
    share = expected_agreement(votes, seen.sum(axis=1))
    score = params.vote_weight * share + (1 - params.vote_weight) * agreement
    known = group != NO_REGION
    return _Fit(np.where(known, score, 0.0), np.where(known, agreement, 0.0))


def _rivals(voted: Int32, group: Int32, own: Int64) -> tuple[Int32, Int64]:
    """Return the other group with most votes of each row, int32 (N,), and its votes int64 (N,).

    Rows where no other group has at least as many votes as the present one have no rival. Among
    equals the lowest number wins, whatever the order of the views.
    """
    rival, votes = np.full(len(group), NO_REGION, np.int32), np.zeros(len(group), np.int64)
    foreign: Bool = (voted != NO_REGION) & (voted != group[:, None])
    row = np.flatnonzero(foreign.sum(axis=1) >= np.maximum(own, 1))
    candidate = np.sort(np.where(foreign[row], voted[row], NO_REGION), axis=1)
    count = (candidate[:, :, None] == candidate[:, None, :]).sum(axis=2, dtype=np.int64)
    count[candidate == NO_REGION] = 0
    best = np.argmax(count, axis=1)
    place = np.arange(len(row))
    rival[row], votes[row] = candidate[place, best], count[place, best]
    return rival, votes
