"""When every voxel came, was last seen, and since when the camera looks through it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Int32, Int64
from sceneq_core.checks import need_at_least, need_within
from sceneq_core.mapping.rows import with_rows
from sceneq_core.mapping.voxels import Moved, Voxels


@dataclass(frozen=True, slots=True)
class PresenceParams:
    """When a voxel that is seen through is gone.

    It takes ``min_views`` keyframes over at least ``min_s`` seconds, with none in between that
    sees the voxel. In a group of which this keyframe sees more than it sees through it takes
    ``hold`` times as many and as long: sensors miss thin parts of what is there.
    """

    min_views: int = 2
    min_s: float = 0.25
    hold: int = 2

    def __post_init__(self) -> None:
        need_at_least(self, 0, "min_s")
        need_at_least(self, 1, "min_views", "hold")
        need_within(self, 1, 255, "min_views")
        if self.min_views * self.hold > 255:  # counted in uint8
            raise ValueError(f"hold: at most {255 // self.min_views} here, got {self.hold}")


@dataclass(frozen=True, slots=True)
class Look:
    """What one keyframe says about the groups in view, parallel rows sorted by ``group`` int32.

    ``seen``, ``through`` and ``lost`` int64 count the voxels of the group that the keyframe shows,
    looks through, and for which that was once too often. ``gone_id`` int32 are the latter, sorted,
    those without a group included.
    """

    group: Int32
    seen: Int64
    through: Int64
    lost: Int64
    gone_id: Int32
    now_ns: int


class Presence:
    """Remembers, per voxel, when it was founded, last seen, and first seen through since then.

    Times are the largest stamp so far, so frames that arrive late count as of now.
    """

    def __init__(self, params: PresenceParams) -> None:
        self._params = params
        self._now_ns = 0
        self._born_ns = np.zeros(0, np.int64)
        self._seen_ns = np.zeros(0, np.int64)
        self._missed_ns = np.zeros(0, np.int64)

    def look(
        self,
        voxels: Voxels,
        touched_id: Int32,
        through_id: Int32,
        group_of: Callable[[Int32], Int32],
        stamp_ns: int,
    ) -> Look:
        """Note what a keyframe touched and saw through; nothing is cleared yet."""
        self._now_ns = max(self._now_ns, stamp_ns)
        self._note_seen(voxels, touched_id)
        self._note_missed(voxels, through_id)
        seen_of, through_of = group_of(touched_id), group_of(through_id)
        count = int(max(seen_of.max(initial=0), through_of.max(initial=0))) + 1
        seen, through = _per_group(seen_of, count), _per_group(through_of, count)
        gone = self._overdue(voxels, through_id, (seen > through)[through_of] & (through_of >= 0))
        lost = _per_group(through_of[gone], count)
        group = np.flatnonzero(seen + through)
        return Look(
            group=group.astype(np.int32),
            seen=seen[group],
            through=through[group],
            lost=lost[group],
            gone_id=np.sort(through_id[gone]),
            now_ns=self._now_ns,
        )

    def seen_since(self, voxel_id: Int32, stamp_ns: int) -> Bool:
        """Tell which voxels were seen at or after a time."""
        return np.asarray(self._seen_ns[voxel_id] >= stamp_ns)

    def born_since(self, voxel_id: Int32, stamp_ns: int) -> Bool:
        """Tell which voxels were empty before a time."""
        return np.asarray(self._born_ns[voxel_id] >= stamp_ns)

    def born_ns(self, voxel_id: Int32) -> int:
        """Return the time from which half of these voxels, at least one, hold what they hold."""
        return int(np.median(self._born_ns[voxel_id]))

    def carry(self, voxels: Voxels, moved: Moved) -> None:
        """Let the times go with surface that was moved elsewhere."""
        self._reserve(len(voxels))
        times = [table[moved.from_id] for table in (self._born_ns, self._seen_ns)]
        self._born_ns[moved.from_id] = 0
        for table, values in zip((self._born_ns, self._seen_ns), times, strict=True):
            np.maximum.at(table, moved.to_id, values)

    def clear(self, voxels: Voxels, voxel_id: Int32) -> None:
        """Empty these voxels; the next to see them founds them again."""
        voxels.clear(voxel_id)
        self._born_ns[voxel_id] = 0

    def _note_seen(self, voxels: Voxels, touched_id: Int32) -> None:
        self._reserve(len(voxels))
        new = touched_id[self._born_ns[touched_id] == 0]
        self._born_ns[new] = max(self._now_ns, 1)
        self._seen_ns[touched_id] = self._now_ns

    def _reserve(self, count: int) -> None:
        self._born_ns = with_rows(self._born_ns, count, 0)
        self._seen_ns = with_rows(self._seen_ns, count, 0)
        self._missed_ns = with_rows(self._missed_ns, count, 0)

    def _note_missed(self, voxels: Voxels, through_id: Int32) -> None:
        first = through_id[voxels.misses[through_id] == 0]
        self._missed_ns[first] = self._now_ns
        misses = voxels.misses[through_id]
        voxels.misses[through_id] = np.where(misses < 255, misses + 1, misses)

    def _overdue(self, voxels: Voxels, through_id: Int32, held: Bool) -> Bool:
        times = np.where(held, self._params.hold, 1)
        waited_ns = self._now_ns - self._missed_ns[through_id]
        enough = voxels.misses[through_id] >= times * self._params.min_views
        return np.asarray(enough & (waited_ns >= times * self._params.min_s * 1e9))


def _per_group(group: Int32, count: int) -> Int64:
    return np.bincount(group[group >= 0], minlength=count)
