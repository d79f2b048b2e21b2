"""Groups that corrected poses brought into one place."""

import numpy as np

from sceneq_core.arrays import Int32
from sceneq_core.mapping.association import Association, GroupChange
from sceneq_core.mapping.correction import Absorbed, CorrectionParams, absorbed
from sceneq_core.mapping.merging import Pairs
from sceneq_core.mapping.superpoints import SuperpointChange, Superpoints
from sceneq_core.mapping.visibility import NOTHING_VISIBLE


def group_of(association: Association, superpoints: Superpoints, voxel_id: Int32) -> Int32:
    """Return the group int32 (N,) of voxels, -1 = none."""
    superpoint = superpoints.of(voxel_id)
    group = association.of(np.maximum(superpoint, 0))
    return np.where(superpoint >= 0, group, -1).astype(np.int32)


def reunite(
    association: Association,
    superpoints: Superpoints,
    change: SuperpointChange,
    keyframe: int,
    surface: tuple[Int32, Int32],
    params: CorrectionParams,
) -> GroupChange:
    """Let groups follow their superpoints, and merge those that are one thing, mapped twice.

    ``surface`` int32 (2, N) is the group of every piece of surface before, and its voxel now.
    """
    before, now_id = surface
    follow = association.update(change, NOTHING_VISIBLE, keyframe)
    found = absorbed(before, group_of(association, superpoints, now_id), params)
    merged = follow.merged + _merge(association, found, follow)
    now = group_of(association, superpoints, now_id)
    concerned = (follow.changed, now[now >= 0], *(np.array(pair) for pair in merged))
    changed = np.unique(np.concatenate(concerned)).astype(np.int32)
    return GroupChange(changed, follow.seen, follow.founded, merged)


def _merge(association: Association, found: Absorbed, follow: GroupChange) -> Pairs:
    """Merge groups into those that absorbed them; leave those that ``follow`` dealt with."""
    group, into = found.group, found.into
    dealt_with = np.isin(group, [number for number, _ in (*follow.merged, *follow.founded)])
    members = [len(association.members(number)) for number in group.tolist()]
    swallowed = found.sure | (np.array(members, np.int64) == 0)
    whole, part = swallowed & ~dealt_with, ~swallowed & ~dealt_with
    association.dissolve(group[whole])
    pairs = zip(group[whole].tolist(), into[whole].tolist(), strict=True)
    return (*pairs, *association.unite(group[part], into[part]))
