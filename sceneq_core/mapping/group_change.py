"""What a keyframe does to the groups of superpoints."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Array, Int32, Int64
from sceneq_core.mapping.merging import Pairs

NO_GROUP = -1


@dataclass(frozen=True, slots=True)
class GroupChange:
    """What a keyframe did to the groups; ``changed`` and ``seen`` are sorted.

    ``changed`` includes emptied groups. ``founded`` holds pairs (group, the group that most of it
    was detached from or -1), ``merged`` pairs (emptied, into), both in the order in which it
    happened: a group may be founded and merged by the same keyframe.
    """

    changed: Int32
    seen: Int32
    founded: Pairs
    merged: Pairs


class Changes:
    """Collects what happens to the groups in one update."""

    def __init__(self) -> None:
        self.founded: Pairs = ()
        self.merged: Pairs = ()
        self._groups: list[Int32] = []

    def note(self, *groups: Array) -> None:
        """Take note of groups that are not what they were; -1 is none."""
        self._groups += [group.astype(np.int32) for group in groups]

    def take(self, change: GroupChange) -> None:
        """Add what happened elsewhere."""
        self.founded += change.founded
        self.merged += change.merged
        self.note(change.changed)

    def found(self, group: Int32, before: Int32, part: Int32) -> None:
        """Found a ``group`` of each ``part`` (N,), from 0, of what was in ``before`` (N,)."""
        left = (before[part == place] for place in range(len(group)))
        self.founded += tuple(zip(group.tolist(), map(_most_frequent, left), strict=True))

    def desert(self, before: Int32, after: Int32, size: Int64) -> None:
        """Merge the groups that are empty now into those that most of them moved to.

        ``before`` and ``after`` int32 (N,) are the groups of what moved, ``size`` int64 (G,)
        counts what is in every group now.
        """
        left = np.unique(before[before != NO_GROUP])
        empty = left[size[left] == 0].tolist()
        self.merged += tuple((group, _most_frequent(after[before == group])) for group in empty)

    def continued(self, before: Int32, after: Int32) -> Pairs:
        """Return pairs (founded, emptied) of groups that are one: merged, and apart again.

        Most of the founded group was the emptied one, and no other has more of it. ``before``
        int32 (N,) and ``after`` (N or more,) are the groups of the superpoints.
        """
        emptied = {group for group, _ in self.merged}
        heirs: dict[int, tuple[int, int]] = {}
        for group, _ in self.founded:
            was = before[after[: len(before)] == group]
            former = _most_frequent(was) if len(was) else NO_GROUP
            shared = int(np.count_nonzero(was == former))
            if former in emptied and 2 * shared > len(was):
                heirs[former] = max(heirs.get(former, (0, 0)), (shared, group))
        return tuple((group, former) for former, (_, group) in sorted(heirs.items()))

    def resume(self, group: int, former: int) -> None:
        """Let ``former``, which was emptied, be what became the founded ``group``."""
        now = {group: former}
        self.founded = tuple((g, now.get(p, p)) for g, p in self.founded if g != group)
        left = (pair for pair in self.merged if pair[0] != former)
        self.merged = tuple((now.get(a, a), now.get(b, b)) for a, b in left)
        self.note(np.array([group, former]))

    def groups(self) -> Int32:
        """Return all groups concerned, sorted."""
        named = np.array([*sum(self.founded, ()), *sum(self.merged, ())], np.int32)
        group: Int32 = np.unique(np.concatenate((*self._groups, named)))
        return np.asarray(group[group != NO_GROUP])


def _most_frequent(number: Int32) -> int:
    """Return the number that occurs most often, the lowest among equals."""
    value, count = np.unique(number, return_counts=True)
    return int(value[np.argmax(count)])
