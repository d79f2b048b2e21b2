"""Which group each superpoint fits best by now, and which superpoints disagree with theirs."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Array, Bool, Float64, Int32, Int64
from sceneq_core.mapping.agreement import RegionViews, expected_agreement
from sceneq_core.mapping.association_params import AssociationParams
from sceneq_core.mapping.borders import Near
from sceneq_core.mapping.coverage import NO_REGION
from sceneq_core.mapping.evidence import NO_SEGMENT
from sceneq_core.mapping.rows import first_of_each

_SHIFT = 32
_LOW = (1 << _SHIFT) - 1


@dataclass(frozen=True, slots=True)
class _Candidates:
    """Pairs of a superpoint and a group that it may belong to, in this order, sorted.

    ``row`` int64 (C,) counts in the superpoints, ``votes`` int64 (C,) the views in which the group
    owns the superpoint's segment, ``share`` float64 (C,) how much of its border goes on into it.
    """

    row: Int64
    group: Int32
    votes: Int64
    share: Float64


def consolidated(
    segment: Int32,
    group: Int32,
    owner: Int32,
    views: RegionViews,
    near: Near,
    params: AssociationParams,
) -> tuple[Int32, Bool]:
    """Return the group int32 (N,) that fits each superpoint best, and who agrees with none (N,).

    ``segment`` int32 (N, V) the evidence of the superpoints, ``group`` int32 (N,) where they are
    now, -1 = none; ``owner`` int32 (S,) the group that covers most of each segment; ``near`` what
    some of them border on, which counts as ``contact_views`` more views.

    A group fits as its segments do: a view is a vote for the owner of the segment it shows. An
    object whose mask fell into pieces still owns each piece, so votes unite; but things glued
    from the first view on would own each other's segments for ever, and it is the agreement with
    the dominant segment that tells them apart.
    """
    seen = segment != NO_SEGMENT
    voted = np.where(seen, owner[segment], NO_REGION)
    one = _candidates(voted, group, near)
    same, common = views.compare_segments(segment[one.row], one.group)
    agreement = expected_agreement(same, common)
    borders = np.zeros(len(group))
    borders[near.row] = params.contact_views
    extra = borders[one.row]
    share = expected_agreement(one.votes + extra * one.share, seen.sum(axis=1)[one.row] + extra)
    likeness = expected_agreement(same + extra * one.share, common + extra)
    score = params.vote_weight * share + (1 - params.vote_weight) * likeness
    present = one.group == group[one.row]
    held, agreed = (_of_rows(one.row[present], x[present], len(group)) for x in (score, agreement))
    better = ~present & (score > np.maximum(params.min_score, held[one.row] + params.hold))
    good = np.flatnonzero(better & (agreement >= params.tau_detach))
    best = first_of_each(good[np.lexsort((one.group[good], -score[good], one.row[good]))], one.row)
    target, alone = group.astype(np.int32), agreed < params.tau_detach
    target[one.row[best]], alone[one.row[best]] = one.group[best], False
    return target, alone


def _candidates(voted: Int32, present: Int32, near: Near) -> _Candidates:
    """Return the groups that each superpoint is in, votes for, or borders on."""
    row, view = np.nonzero(voted != NO_REGION)
    known = np.flatnonzero(present != NO_REGION)
    vote, border = _packed(row, voted[row, view]), _packed(near.row, near.group)
    key = np.unique(np.concatenate((vote, border, _packed(known, present[known]))))
    return _Candidates(
        row=key >> _SHIFT,
        group=(key & _LOW).astype(np.int32),
        votes=np.bincount(np.searchsorted(key, vote), minlength=len(key)).astype(np.int64),
        share=np.bincount(np.searchsorted(key, border), near.share, len(key)).astype(np.float64),
    )


def _packed(row: Int64, group: Int32) -> Int64:
    return row << _SHIFT | group.astype(np.int64)


def _of_rows(row: Int64, value: Array, count: int) -> Float64:
    """Return float64 (count,) with the values of distinct rows, 0 elsewhere."""
    spread = np.zeros(count)
    spread[row] = value
    return spread
