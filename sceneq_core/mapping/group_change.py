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

    def groups(self) -> Int32:
        """Return all groups concerned, sorted."""
        named = np.array([*sum(self.founded, ()), *sum(self.merged, ())], np.int32)
        group: Int32 = np.unique(np.concatenate((*self._groups, named)))
        return np.asarray(group[group != NO_GROUP])


def deserted(before: Int32, after: Int32, size: Int64) -> Pairs:
    """Return the groups that are empty now, each with the group most of it moved to.

    ``before`` and ``after`` int32 (N,) are the groups of what moved, ``size`` int64 (G,) counts
    what is in every group now.
    """
    left = np.unique(before[before != NO_GROUP])
    empty = left[size[left] == 0].tolist()
    return tuple((group, most_frequent(after[before == group])) for group in empty)


def most_frequent(number: Int32) -> int:
    """Return the number that occurs most often, the lowest among equals."""
    value, count = np.unique(number, return_counts=True)
    return int(value[np.argmax(count)])
