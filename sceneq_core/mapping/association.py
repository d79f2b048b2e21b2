"""Which superpoints form one object: agreement of the 2D segments over the keyframes."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Array, Bool, Float64, Int32, Int64
from sceneq_core.checks import need_at_least, need_between
from sceneq_core.mapping.evidence import NO_SEGMENT, Evidence, agreement
from sceneq_core.mapping.ids import Ids
from sceneq_core.mapping.rows import first_of_each, with_rows
from sceneq_core.mapping.superpoints import SuperpointChange
from sceneq_core.mapping.visibility import Visible

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
        need_at_least(self, 1, "views", "min_common_views", "min_pixels")
        need_between(self, 0, 1, "min_agreement")
        if not 0.0 <= self.hold < self.min_agreement:
            raise ValueError(f"hold: must be at least 0, below min_agreement, got {self.hold}")
        if not 0.5 <= self.merge_agreement < 1.0:
            raise ValueError(f"merge_agreement: must be in [0.5, 1), got {self.merge_agreement}")


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
        self._groups = Ids()
        self._segments = 0

    def __len__(self) -> int:
        """Return one more than the largest group number given so far."""
        return len(self._groups)

    def of(self, superpoint_id: Int32) -> Int32:
        """Return the groups of superpoints, -1 = none."""
        return self._of_superpoint[superpoint_id]

    def members(self, group: int) -> Int32:
        """Return the sorted superpoint ids of a group."""
        return np.flatnonzero(self._of_superpoint == group).astype(np.int32)

    def update(self, change: SuperpointChange, visible: Visible, keyframe: int) -> GroupChange:
        """Add the evidence of one keyframe and regroup what it shows."""
        inherited = self._inherit(change, visible)
        before = self.of(visible.superpoint_id)
        self._record_superpoints(visible, keyframe)
        dominance = self._record_groups(visible, keyframe)
        self._reassign(visible, dominance)
        founded = self._found(visible, before)
        merged = self._merge(dominance)
        after = self.of(visible.superpoint_id)
        emptied = np.array([small for small, _ in merged], np.int32)
        changed = np.unique(np.concatenate((inherited, before, after, emptied)))
        changed = changed[changed >= 0]
        self._release(changed)
        seen = np.sort(np.concatenate((dominance.group, [group for group, _ in founded])))
        return GroupChange(changed, seen.astype(np.int32), founded, merged)

    def _inherit(self, change: SuperpointChange, visible: Visible) -> Int32:
        """Let new superpoints continue as what they came out of; return the groups concerned."""
        largest = max(change.new_id.max(initial=-1), visible.superpoint_id.max(initial=-1))
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

    def _record_superpoints(self, visible: Visible, keyframe: int) -> None:
        segment = np.where(visible.label > 0, self._segments + visible.label, NO_SEGMENT)
        self._superpoint_evidence.record(visible.superpoint_id, keyframe, segment)

    def _record_groups(self, visible: Visible, keyframe: int) -> _Dominance:
        group = self.of(visible.superpoint_id)
        known = (group >= 0) & (visible.label > 0)
        labels = int(visible.label.max(initial=0)) + 1
        pair, row = np.unique(
            group[known] * np.int64(labels) + visible.label[known], return_inverse=True
        )
        pixels = np.bincount(row, visible.pixels[known], len(pair))
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

    def _reassign(self, visible: Visible, dominance: _Dominance) -> None:
        """Move each superpoint to the group of its segment when that agrees better over time."""
        superpoint, own = visible.superpoint_id, self.of(visible.superpoint_id)
        candidate = np.where(visible.label > 0, dominance.owner[visible.label], NO_GROUP)
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

    def _found(self, visible: Visible, before: Int32) -> tuple[tuple[int, int], ...]:
        """Let the superpoints of one segment that no group claims form a group of their own."""
        alone = (self.of(visible.superpoint_id) < 0) & (visible.label > 0)
        label, row = np.unique(visible.label[alone], return_inverse=True)
        pixels = np.bincount(row, visible.pixels[alone], len(label))
        kept = np.flatnonzero(pixels >= self._params.min_pixels)
        group = self._groups.take(len(kept))
        self._group_evidence.reserve(len(self))
        of_label = np.full(len(label), NO_GROUP, np.int64)
        of_label[kept] = np.arange(len(kept))
        member = of_label[row] >= 0
        superpoint, position = visible.superpoint_id[alone][member], of_label[row][member]
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

    def _release(self, group: Int32) -> None:
        """Give the numbers of emptied groups free for later ones."""
        used = np.bincount(self._of_superpoint[self._of_superpoint >= 0], minlength=len(self))
        empty = group[used[group] == 0]
        self._group_evidence.forget(empty)
        self._groups.give_back(empty)


def _largest_of_each(key: Int64, size: Array) -> Int64:
    """Return, per distinct key, the row of the largest size (the first one among equals)."""
    return first_of_each(np.lexsort((-size, key)), key)


def _most_frequent(number: Int32) -> int:
    value, count = np.unique(number, return_counts=True)
    return int(value[np.argmax(count)])


def _pairs_with_equal(label: Int32) -> tuple[Int64, Int64]:
    equal: Bool = label[:, None] == label[None, :]
    first, second = np.nonzero(np.triu(equal, k=1))
    return first, second
