"""Which regions are one thing: those that the views show as one segment."""

import numpy as np

from sceneq_core.arrays import Bool, Int32, Int64
from sceneq_core.mapping.agreement import RegionViews, expected_agreement
from sceneq_core.mapping.association_params import AssociationParams
from sceneq_core.mapping.borders import Borders
from sceneq_core.mapping.evidence import NO_SEGMENT
from sceneq_core.mapping.kinships import Kinships
from sceneq_core.mapping.rows import sorted_keys

Pairs = tuple[tuple[int, int], ...]
_SHIFT = 32
_LOW = (1 << _SHIFT) - 1


def merging_pairs(
    views: RegionViews,
    in_view: Bool,
    borders: Borders,
    kinships: Kinships,
    params: AssociationParams,
) -> Pairs:
    """Return disjoint pairs of regions that agree by more than ``tau_merge``, the best first.

    While one of them is in view, bool (R,), it takes ``min_common_views``. Once both are out of
    view there is nothing to wait for: what they look like counts as ``kinship_views`` more views,
    of which the kinship, 0 to 1, is the share that shows them as one.
    """
    first, second = _candidates(views, kinships.meeting(borders, in_view))
    same, common = views.compare(first, second)
    score = expected_agreement(same, common)
    score[common < params.min_common_views] = 0.0
    extra = params.kinship_views
    best = expected_agreement(same + extra, common + extra)
    left = np.flatnonzero(~in_view[first] & ~in_view[second] & (best > params.tau_merge))
    alike = extra * kinships.of(borders, first[left], second[left])
    score[left] = expected_agreement(same[left] + alike, common[left] + extra)
    good = np.flatnonzero(score > params.tau_merge)
    order = good[np.lexsort((second[good], first[good], -score[good]))]
    pairs: list[tuple[int, int]] = []
    busy: set[int] = set()
    for pair in zip(first[order].tolist(), second[order].tolist(), strict=True):
        if busy.isdisjoint(pair):
            busy.update(pair)
            pairs.append(pair)
    return tuple(pairs)


def united(pairs: Pairs, size: Int64) -> tuple[Pairs, Int32]:
    """Return pairs (smaller, larger) and where each region goes, int32 (R + 1,), the last is -1.

    ``size`` int64 (R,) of the regions; of equals the second goes into the first.
    """
    merged = tuple((a, b) if size[a] < size[b] else (b, a) for a, b in pairs)
    into = np.append(np.arange(len(size), dtype=np.int32), np.int32(-1))
    into[[small for small, _ in merged]] = [large for _, large in merged]
    return merged, into


def _candidates(views: RegionViews, meeting: Int64) -> tuple[Int64, Int64]:
    """Return the pairs of regions that a segment shows, or that meet out of view."""
    pair = sorted_keys(_sharing(views), meeting)
    return pair >> _SHIFT, pair & _LOW


def _sharing(views: RegionViews) -> Int64:
    """Return the pairs of regions that have a dominant segment in common in any view, packed."""
    region, place = np.nonzero(views.top != NO_SEGMENT)
    key = np.sort(views.top[region, place].astype(np.int64) << _SHIFT | region)
    segment, region = key >> _SHIFT, key & _LOW
    pairs = []
    step = 1
    while (equal := segment[step:] == segment[:-step]).any():
        pairs.append((region[:-step][equal] << _SHIFT) | region[step:][equal])
        step += 1
    return sorted_keys(np.zeros(0, np.int64), *pairs)
