"""Which superpoints form one object: agreement of the 2D segments over the keyframes."""

from collections.abc import Callable

import numpy as np

from sceneq_core.arrays import Array, Bool, Int32, Int64
from sceneq_core.mapping.agreement import RegionViews, expected_agreement
from sceneq_core.mapping.association_params import AssociationParams
from sceneq_core.mapping.borders import Borders
from sceneq_core.mapping.consolidation import consolidated
from sceneq_core.mapping.coverage import Coverage
from sceneq_core.mapping.detachment import ATTACHED, detached_parts
from sceneq_core.mapping.evidence import NO_SEGMENT, Evidence
from sceneq_core.mapping.group_change import NO_GROUP, Changes, GroupChange
from sceneq_core.mapping.ids import Ids
from sceneq_core.mapping.mask_segments import NO_MASK, MaskSegments
from sceneq_core.mapping.merging import Pairs, merging_pairs, united
from sceneq_core.mapping.neighbourhood import Neighbourhood
from sceneq_core.mapping.region_table import NO_COLUMN
from sceneq_core.mapping.rows import marked, sorted_keys, with_rows
from sceneq_core.mapping.superpoints import SuperpointChange
from sceneq_core.mapping.visibility import Visible

_MANY_SEGMENTS = 1 << 16
"""Segments, about an hour of keyframes, from which those without evidence lose their numbers."""

__all__ = ["NO_GROUP", "Association", "GroupChange"]


class Association:
    """Groups of superpoints, each a candidate for an instance.

    The refinement of the paper, kept up to date keyframe by keyframe: superpoints consolidate in
    the group that owns their segments, parts that the views show apart are detached, groups that
    they show as one are merged, until nothing changes. Only superpoints in view, and those whose
    segments changed hands, are looked at: the others would decide as they did.
    """

    def __init__(self, params: AssociationParams) -> None:
        self._params = params
        self._of_superpoint = np.full(0, NO_GROUP, np.int32)
        self._evidence = Evidence(params.views)
        self._coverage = Coverage(params.top_views, params.min_pixels)
        self._neighbourhood = Neighbourhood()
        self._groups = Ids()
        self._mask_segments = MaskSegments()
        self._renumber_at = _MANY_SEGMENTS
        self._decided = self._owner

    def __len__(self) -> int:
        """Return one more than the largest group number given so far."""
        return len(self._groups)

    def of(self, superpoint_id: Array) -> Int32:
        """Return the groups of superpoints, -1 = none."""
        return self._of_superpoint[superpoint_id]

    def members(self, group: int) -> Int32:
        """Return the sorted superpoint ids of a group."""
        return np.flatnonzero(self._of_superpoint == group).astype(np.int32)

    def update(
        self,
        change: SuperpointChange,
        visible: Visible,
        keyframe: int,
        entering: Callable[[], GroupChange] | None = None,
    ) -> GroupChange:
        """Add the evidence of one keyframe and refine the groups that it concerns.

        ``entering`` lets external proposals ``found`` groups of the superpoints that have come.
        """
        changes = Changes()
        if self._coverage.segments > self._renumber_at:
            self.renumber()
        self._inherit(change, visible, changes)
        if entering:
            changes.take(entering())
        changes.note(self.of(visible.superpoint_id))
        before = self._of_superpoint.copy()
        segment = self._record(visible, keyframe)
        self._refine(self._neighbourhood.follow(change, visible, self._of_superpoint), changes)
        self._resume(before, changes)
        changes.note(self.of(visible.superpoint_id))
        return self._change(changes, self._seen(segment))

    def settle(self) -> GroupChange:
        """Reconsider every superpoint until nothing changes; after a settled stream, nothing."""
        changes = Changes()
        everyone = np.arange(len(self._of_superpoint), dtype=np.int32)
        while self._refine(everyone, changes):
            everyone = everyone[:0]
        return self._change(changes, np.zeros(0, np.int32))

    def found(self, superpoint_id: Int32, mask: Int32, group: Int32, views: int) -> GroupChange:
        """Put distinct superpoints into the groups of external masks, seen as in ``views`` views.

        ``mask`` int32 (N,) are numbers from 0, -1 = none; ``group`` int32 (N,) the group of the
        mask, -1 where it has to be founded. Masks are segments of views that no camera took: what
        the keyframes show outvotes them.
        """
        changes = Changes()
        given = mask != NO_MASK
        superpoint_id, mask, group = superpoint_id[given], mask[given], group[given].copy()
        new, row = np.unique(mask[group == NO_GROUP], return_inverse=True)
        founded = self._groups.take(len(new))
        group[group == NO_GROUP] = founded[row]
        changes.founded = tuple((number, NO_GROUP) for number in founded.tolist())
        changes.note(self.of(superpoint_id), group)
        self._assign(superpoint_id, np.full(len(group), NO_GROUP, np.int32))
        pixels = np.full(len(group), self._params.min_pixels, np.int64)
        for view in range(views):
            segment = self._mask_segments.numbers(mask, view, self._coverage)
            self._evidence.record(superpoint_id, segment, pixels)
        self._assign(superpoint_id, group)
        return GroupChange(changes.groups(), np.zeros(0, np.int32), changes.founded, ())

    def unite(self, first: Int32, second: Int32) -> Pairs:
        """Merge pairs of groups found in one place, unless a view tells the two apart.

        Returns pairs (emptied, into); a group that was emptied is not merged again.
        """
        same, common = self._views.compare(first, second)
        # Mapped twice, at different times: mostly no view shows both.
        together = (common == 0) | (expected_agreement(same, common) >= self._params.tau_merge)
        pairs: list[tuple[int, int]] = []
        gone: set[int] = set()
        for a, b in zip(first[together].tolist(), second[together].tolist(), strict=True):
            if gone.isdisjoint((a, b)):
                pairs += self._unite(((a, b),))
                gone.add(pairs[-1][0])
        self._release(np.array(sorted(gone), np.int32))
        return tuple(pairs)

    def dissolve(self, group: Int32) -> None:
        """Let go of the superpoints of these groups, and of what was seen of them."""
        superpoint_id = np.flatnonzero(np.isin(self._of_superpoint, group)).astype(np.int32)
        self._assign(superpoint_id, np.full(len(superpoint_id), NO_GROUP, np.int32))
        self._evidence.forget(superpoint_id)
        self._release(group)

    def renumber(self) -> None:
        """Forget segments that no superpoint has evidence of any more; no group changes."""
        live = np.zeros(self._coverage.segments, np.bool_)
        live[NO_SEGMENT] = True
        live[self._evidence.segments(np.arange(len(self._evidence)))] = True
        live[self._mask_segments.all_numbers()] = True
        kept, number = np.flatnonzero(live), (np.cumsum(live) - 1).astype(np.int32)
        self._evidence.renumber(number)
        self._coverage.renumber(kept, number)
        self._mask_segments.renumber(number)
        self._decided = self._decided[kept[kept < len(self._decided)]]
        self._renumber_at = max(_MANY_SEGMENTS, 2 * len(kept))

    def _inherit(self, change: SuperpointChange, visible: Visible, changes: Changes) -> None:
        """Let new superpoints continue as what they came out of, with its evidence."""
        largest = max(change.new_id.max(initial=-1), visible.superpoint_id.max(initial=-1))
        self._of_superpoint = with_rows(self._of_superpoint, int(largest) + 1, NO_GROUP)
        self._evidence.reserve(int(largest) + 1)
        heir = change.parent_id >= 0
        child, parent = change.new_id[heir], change.parent_id[heir]
        changes.note(self.of(parent), self.of(change.gone_id))
        self._evidence.copy(child, parent)
        self._assign(child, self.of(parent))
        self._assign(change.gone_id, np.full(len(change.gone_id), NO_GROUP, np.int32))
        self._evidence.forget(change.gone_id)

    def _record(self, visible: Visible, keyframe: int) -> int:
        """Enter what dominates the visible superpoints; return the first new segment's number."""
        shown = visible.label > 0
        superpoint, pixels = visible.superpoint_id[shown], visible.pixels[shown]
        label, row = np.unique(visible.label[shown], return_inverse=True)
        first = self._coverage.open_segments(len(label), keyframe)
        segment = (first + row).astype(np.int32)
        old_segment, old_pixels = self._evidence.record(superpoint, segment, pixels)
        group = self.of(superpoint)
        self._coverage.add(group, old_segment, -old_pixels)
        self._coverage.add(group, segment, pixels)
        return first

    def _refine(self, superpoint_id: Int32, changes: Changes) -> bool:
        """Refine in rounds, first of ``superpoint_id``; return whether something is left to do."""
        for _ in range(self._params.max_rounds):
            superpoint_id = sorted_keys(superpoint_id, self._disturbed())
            if not len(superpoint_id):
                return False
            self._decided = self._owner
            self._coverage.decide()
            self._neighbourhood.calm()
            self._consolidate_and_detach(superpoint_id, changes)
            self._merge(changes)
            superpoint_id = superpoint_id[:0]
        return len(self._disturbed()) > 0

    def _consolidate_and_detach(self, superpoint_id: Int32, changes: Changes) -> None:
        before = self.of(superpoint_id)
        segment = self._evidence.segments(superpoint_id)
        near = self._borders().around(superpoint_id)
        target, alone = consolidated(segment, before, self._owner, self._views, near, self._params)
        part = detached_parts(
            superpoint_id[alone],
            before[alone],
            self._evidence,
            self._coverage,
            self._views,
            self._borders(),
            self._params,
        )
        founded = self._groups.take(int(part.max(initial=ATTACHED)) + 1)
        target[alone] = np.where(part == ATTACHED, before[alone], np.append(founded, 0)[part])
        changes.found(founded, before[alone], part)
        moving = target != before
        if not moving.any():
            return
        changes.note(before[moving], target[moving])
        self._assign(superpoint_id[moving], target[moving])
        changes.desert(before[moving], target[moving], self._sizes())

    def _merge(self, changes: Changes) -> None:
        kinships = self._neighbourhood.kinships
        while pairs := merging_pairs(
            self._views, self._in_view(), self._borders(), kinships, self._params
        ):
            changes.merged += self._unite(pairs)

    def _resume(self, before: Int32, changes: Changes) -> None:
        """Give what was merged and taken out again its number back: it is the group it was."""
        for group, former in changes.continued(before, self._of_superpoint):
            members = self.members(group)
            self._assign(members, np.full(len(members), former, np.int32))
            changes.resume(group, former)

    def _unite(self, pairs: Pairs) -> Pairs:
        """Move the superpoints of the smaller of each pair; return pairs (emptied, into)."""
        merged, into = united(pairs, self._sizes())
        moving = np.flatnonzero(into[self._of_superpoint] != self._of_superpoint).astype(np.int32)
        self._assign(moving, into[self.of(moving)])
        return merged

    def _assign(self, superpoint_id: Int32, group: Int32) -> None:
        """Put distinct superpoints into groups, with all their evidence."""
        entries = self._evidence.entries(superpoint_id)
        before = self.of(superpoint_id)
        self._coverage.add(
            np.concatenate((before[entries.row], group[entries.row])),
            np.concatenate((entries.segment, entries.segment)),
            np.concatenate((-entries.pixels, entries.pixels)),
        )
        self._of_superpoint[superpoint_id] = group
        self._neighbourhood.move(superpoint_id, before, group)

    @property
    def _owner(self) -> Int32:
        return self._coverage.owners()

    @property
    def _views(self) -> RegionViews:
        return self._coverage.region_views(len(self))

    def _disturbed(self) -> Int32:
        """Return the superpoints that may decide anew: of changed segments, beside what moved."""
        changed, owner = self._coverage.differing(), self._decided
        changed[: len(owner)] |= self._owner[: len(owner)] != owner
        may_show = self._coverage.covering(changed, len(self))
        own = self._evidence.showing(changed, may_show[self._of_superpoint])
        return sorted_keys(own, self._neighbourhood.disturbed())

    def _in_view(self) -> Bool:
        """Mark the groups (G,) of which the last keyframe shows something."""
        return marked(self.of(self._neighbourhood.in_view), len(self) + 1)

    def _borders(self) -> Borders:
        return self._neighbourhood.borders(self._of_superpoint)

    def _seen(self, first_segment: int) -> Int32:
        """Return the groups that have a view in the keyframe of the latest segments."""
        column = int(self._views.column[first_segment:].max(initial=NO_COLUMN))
        return np.flatnonzero(self._views.segment[:, column] >= first_segment).astype(np.int32)

    def _change(self, changes: Changes, seen: Int32) -> GroupChange:
        changed = changes.groups()
        self._release(changed)
        return GroupChange(changed, seen, changes.founded, changes.merged)

    def _release(self, group: Int32) -> None:
        """Give the numbers of emptied groups free for later ones."""
        self._groups.give_back(group[self._sizes()[group] == 0])

    def _sizes(self) -> Int64:
        grouped = self._of_superpoint[self._of_superpoint != NO_GROUP]
        return np.bincount(grouped, minlength=len(self)).astype(np.int64)
