"""Superpoints that leave their group together, because the views show them apart from it."""

import numpy as np

from sceneq_core.arrays import Bool, Int32, Int64
from sceneq_core.mapping.agreement import RegionViews, expected_agreement
from sceneq_core.mapping.association_params import AssociationParams
from sceneq_core.mapping.borders import Borders
from sceneq_core.mapping.coverage import NO_REGION, Coverage
from sceneq_core.mapping.evidence import NO_SEGMENT, Evidence

ATTACHED = -1


def detached_parts(
    superpoint_id: Int32,
    group: Int32,
    evidence: Evidence,
    coverage: Coverage,
    views: RegionViews,
    borders: Borders,
    params: AssociationParams,
) -> Int32:
    """Return the detached part int32 (N,) of superpoints that disagree with their ``group``.

    A part is what one segment shows of one group in the latest view, and parts are numbered from
    0; superpoints that stay where they are have ``ATTACHED``. A part is detached when it agrees
    with its group by less than ``tau_detach``, their kinship counted as in merging, and only those
    of it go that agree with the part: what agrees with nothing would be no better off.
    Superpoints without a group (-1) always go.
    """
    segment, pixels = evidence.latest(superpoint_id)
    pair, part = np.unique(group.astype(np.int64) << 32 | segment, return_inverse=True)
    former, latest = (pair >> 32).astype(np.int32), pair & ((1 << 32) - 1)
    size = np.bincount(part, pixels, len(pair))
    part_views = _views_of_parts(superpoint_id, part, evidence, coverage, len(pair))
    same, common = views.compare_segments(part_views.top[:-1], former)
    extra, grouped = params.kinship_views, former != NO_REGION
    may_leave = (latest != NO_SEGMENT) & (size >= params.min_pixels)
    # Kinship is looked up only where it can tip the balance.
    least, most = (expected_agreement(same + more, common + extra) for more in (0, extra))
    doubtful = may_leave & grouped & (least < params.tau_detach) & (most >= params.tau_detach)
    alike = np.zeros(len(pair))
    alike[doubtful] = extra * borders.kinship_of_parts(superpoint_id, part, former, doubtful)
    apart = expected_agreement(same + alike, common + extra) < params.tau_detach
    leaves = may_leave & (apart | ~grouped)
    unlike = _disagree(evidence.segments(superpoint_id), part.astype(np.int32), part_views, params)
    goes = leaves[part] & (~unlike | (group == NO_REGION))
    result = np.full(len(part), ATTACHED, np.int32)
    result[goes] = np.unique(part[goes], return_inverse=True)[1]
    return result


def _views_of_parts(
    superpoint_id: Int32, part: Int64, evidence: Evidence, coverage: Coverage, parts: int
) -> RegionViews:
    entries = evidence.entries(superpoint_id)
    return coverage.views_of(part[entries.row], entries.segment, entries.pixels, parts)


def _disagree(segment: Int32, region: Int32, views: RegionViews, params: AssociationParams) -> Bool:
    """Tell which things, seen as ``segment`` (N, V), agree too little with their ``region``."""
    agreement = expected_agreement(*views.compare_segments(segment, region))
    return np.asarray(agreement < params.tau_detach)
