"""Which superpoints form one object: agreement of the 2D segments over the keyframes."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Array, Bool, Float64, Int32, Int64
from sceneq_core.mapping.evidence import NO_SEGMENT, Evidence, agreement
from sceneq_core.mapping.growing import with_rows
from sceneq_core.mapping.superpoints import SuperpointChange
from sceneq_core.mapping.visibility import Sighting

NO_GROUP = -1


@dataclass(frozen=True, slots=True)
class AssociationParams:
    """When superpoints belong together.

    ``views`` keyframes of evidence are kept per superpoint and per group; ``min_agreement`` (see
    ``agreement``) is needed to join a group, and ``hold`` is the hysteresis in favour of the
    present one; two groups merge from ``merge_agreement`` over ``min_common_views``; a group is
    seen in a keyframe, and founded, with at least ``min_pixels`` surface points.
    """

    views: int = 32
    min_agreement: float = 0.5
    hold: float = 0.1
    merge_agreement: float = 0.6
    min_common_views: int = 2
    min_pixels: int = 10

    def __post_init__(self) -> None:
        if self.views < 1:
            raise ValueError(f"views: must be at least 1, got {self.views}")
        if not 0.0 < self.min_agreement < 1.0:
            raise ValueError(f"min_agreement: must be in 0..1, got {self.min_agreement}")
        if not 0.0 <= self.hold < self.min_agreement:
            raise ValueError(f"hold: must be in 0..min_agreement, got {self.hold}")
        if not 0.5 <= self.merge_agreement < 1.0:
            raise ValueError(f"merge_agreement: must be in 0.5..1, got {self.merge_agreement}")
        if self.min_common_views < 1:
            raise ValueError(f"min_common_views: must be at least 1, got {self.min_common_views}")
        if self.min_pixels < 1:
            raise ValueError(f"min_pixels: must be at least 1, got {self.min_pixels}")


@dataclass(frozen=True, slots=True)
class GroupChange:
    """What a keyframe did to the groups; ``changed`` and ``seen`` are sorted.

    ``changed`` includes emptied groups; ``founded`` holds pairs (group, the group that most of it
    left or -1), ``merged`` pairs (emptied, into).
    """

    changed: Int32
    seen: Int32
    founded: tuple[tuple[int, int], ...]
    merged: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class _Dominance:
    """The groups in view with the segment that dominates each; ``owner`` group per label."""

    group: Int32
    label: Int32
    owner: Int32


class Association:
    """Groups of superpoints, each a candidate for an instance."""

    def __init__(self, params: AssociationParams) -> None:
        self._params = params
        self._of_superpoint = np.full(0, NO_GROUP, np.int32)
        self._superpoint_evidence = Evidence(params.views)
        self._group_evidence = Evidence(params.views)
        self._count = 0
        self._free: list[int] = []
        self._segments = 0

    def __len__(self) -> int:
        """Return one more than the largest group number given so far."""
        return self._count

    def of(self, superpoint_id: Int32) -> Int32:
        """Return the groups of superpoints, -1 = none."""
        return self._of_superpoint[superpoint_id]

    def members(self, group: int) -> Int32:
        """Return the sorted superpoint ids of a group."""
        return np.flatnonzero(self._of_superpoint == group).astype(np.int32)

    def update(self, change: SuperpointChange, sighting: Sighting, keyframe: int) -> GroupChange:
        """Add the evidence of one keyframe and regroup what it shows."""
        inherited = self._inherit(change, sighting)
        before = self.of(sighting.superpoint_id)
        self._record_superpoints(sighting, keyframe)
        dominance = self._record_groups(sighting, keyframe)
        self._reassign(sighting, dominance)
        founded = self._found(sighting, before)
        merged = self._merge(dominance)
        after = self.of(sighting.superpoint_id)
        emptied = np.array([small for small, _ in merged], np.int32)
        changed = np.unique(np.concatenate((inherited, before, after, emptied)))
        changed = changed[changed >= 0]
        self._release(changed)
        seen = np.sort(np.concatenate((dominance.group, [group for group, _ in founded])))
        return GroupChange(changed, seen.astype(np.int32), founded, merged)

    def _inherit(self, change: SuperpointChange, sighting: Sighting) -> Int32:
        """Let new superpoints continue as what they came out of; return the groups concerned."""
        largest = max(change.new_id.max(initial=-1), sighting.superpoint_id.max(initial=-1))
        self._of_superpoint = with_rows(self._of_superpoint, int(largest) + 1, NO_GROUP)
        self._superpoint_evidence.reserve(int(largest) + 1)
        heir = change.parent_id >= 0
        child, parent = change.new_id[heir], change.parent_id[heir]
        self._of_superpoint[child] = self._of_superpoint[parent]
        self._superpoint_evidence.copy(child, self._superpoint_evidence, parent)
        concerned = self.of(np.concatenate((child, change.gone_id)))
        self._of_superpoint[change.gone_id] = NO_GROUP
        self._superpoint_evidence.forget(change.gone_id)
        return concerned

    def _record_superpoints(self, sighting: Sighting, keyframe: int) -> None:
        segment = np.where(sighting.label > 0, self._segments + sighting.label, NO_SEGMENT)
        self._superpoint_evidence.record(sighting.superpoint_id, keyframe, segment)

    def _record_groups(self, sighting: Sighting, keyframe: int) -> _Dominance:
        group = self.of(sighting.superpoint_id)
        known = (group >= 0) & (sighting.label > 0)
        labels = int(sighting.label.max(initial=0)) + 1
        pair, row = np.unique(
            group[known] * np.int64(labels) + sighting.label[known], return_inverse=True
        )
        pixels = np.bincount(row, sighting.pixels[known], len(pair))
        enough = pixels >= self._params.min_pixels
        pair, pixels = pair[enough], pixels[enough]
        dominant = _largest_of_each(pair // labels, pixels)
        group, label, pixels = pair[dominant] // labels, pair[dominant] % labels, pixels[dominant]
        self._group_evidence.record(group, keyframe, self._segments + label)
        self._segments += labels
        owner = np.full(labels, NO_GROUP, np.int32)
        largest = _largest_of_each(label, pixels)
        owner[label[largest]] = group[largest]
        return _Dominance(group.astype(np.int32), label.astype(np.int32), owner)

    def _reassign(self, sighting: Sighting, dominance: _Dominance) -> None:
        """Move each superpoint to the group of its segment when that agrees better over time."""
        superpoint, own = sighting.superpoint_id, self.of(sighting.superpoint_id)
        candidate = np.where(sighting.label > 0, dominance.owner[sighting.label], NO_GROUP)
        own_agreement = self._agreement_with(superpoint, own)
        candidate_agreement = self._agreement_with(superpoint, candidate)
        needed = np.maximum(self._params.min_agreement, own_agreement + self._params.hold)
        moving = (candidate != own) & (candidate_agreement > needed)
        leaving = ~moving & (own_agreement < self._params.min_agreement - self._params.hold)
        target = np.where(moving, candidate, np.where(leaving, NO_GROUP, own))
        self._of_superpoint[superpoint] = target

    def _agreement_with(self, superpoint: Int32, group: Int32) -> Float64:
        result = np.where(group >= 0, 0.5, 0.0)
        known = group >= 0
        result[known] = agreement(
            *self._superpoint_evidence.compare(
                superpoint[known], self._group_evidence, group[known]
            )
        )
        return result

    def _found(self, sighting: Sighting, before: Int32) -> tuple[tuple[int, int], ...]:
        """Let the superpoints of one segment that no group claims form a group of their own."""
        alone = (self.of(sighting.superpoint_id) < 0) & (sighting.label > 0)
        label, row = np.unique(sighting.label[alone], return_inverse=True)
        pixels = np.bincount(row, sighting.pixels[alone], len(label))
        kept = np.flatnonzero(pixels >= self._params.min_pixels)
        group = self._take(len(kept))
        of_label = np.full(len(label), NO_GROUP, np.int64)
        of_label[kept] = np.arange(len(kept))
        member = of_label[row] >= 0
        superpoint, position = sighting.superpoint_id[alone][member], of_label[row][member]
        self._of_superpoint[superpoint] = group[position]
        self._group_evidence.take_majority(
            group, self._superpoint_evidence, superpoint, position.astype(np.int32)
        )
        left = before[alone][member]
        return tuple(
            (number, _most_frequent(left[position == place]))
            for place, number in enumerate(group.tolist())
        )

    def _merge(self, dominance: _Dominance) -> tuple[tuple[int, int], ...]:
        """Merge groups in view that agree; a group takes part in one merge per keyframe."""
        first, second = _pairs_with_equal(dominance.label)
        a, b = dominance.group[first], dominance.group[second]
        same, common = self._group_evidence.compare(a, self._group_evidence, b)
        score = agreement(same, common)
        good = (score >= self._params.merge_agreement) & (common >= self._params.min_common_views)
        merged: list[tuple[int, int]] = []
        busy: set[int] = set()
        for row in np.lexsort((b, a, -score)):
            pair = int(a[row]), int(b[row])
            if good[row] and busy.isdisjoint(pair):
                busy.update(pair)
                merged.append(self._unite(*pair))
        return tuple(merged)

    def _unite(self, a: int, b: int) -> tuple[int, int]:
        small, large = (a, b) if len(self.members(a)) < len(self.members(b)) else (b, a)
        self._of_superpoint[self._of_superpoint == small] = large
        self._group_evidence.absorb(large, small)
        return small, large

    def _take(self, count: int) -> Int32:
        again = [self._free.pop() for _ in range(min(count, len(self._free)))]
        fresh = range(self._count, self._count + count - len(again))
        self._count += len(fresh)
        self._group_evidence.reserve(self._count)
        return np.array([*again, *fresh], np.int32)

    def _release(self, group: Int32) -> None:
        """Give the numbers of emptied groups free for later ones."""
        used = np.bincount(self._of_superpoint[self._of_superpoint >= 0], minlength=self._count)
        empty = group[used[group] == 0]
        self._group_evidence.forget(empty)
        self._free = sorted({*self._free, *empty.tolist()}, reverse=True)


def _largest_of_each(key: Int64, size: Array) -> Int64:
    """Return, per distinct key, the row of the largest size (the first one among equals)."""
    order = np.lexsort((-size, key))
    return order[np.unique(key[order], return_index=True)[1]]


def _most_frequent(number: Int32) -> int:
    value, count = np.unique(number, return_counts=True)
    return int(value[np.argmax(count)])


def _pairs_with_equal(label: Int32) -> tuple[Int64, Int64]:
    equal: Bool = label[:, None] == label[None, :]
    first, second = np.nonzero(np.triu(equal, k=1))
    return first, second
