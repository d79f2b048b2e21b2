"""Which state of the map an answer is of."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from sceneq_core.mapping.delta import Instance


@dataclass(frozen=True, slots=True)
class Revision:
    """A state of the map: ``frame_seq`` of its newest keyframe, ``stamp_ns`` the time in it."""

    epoch: int = 0
    seq: int = 0
    frame_seq: int = -1
    stamp_ns: int = 0

    def after(self, before: "Revision", changed: Iterable[Instance]) -> "Revision":
        """Return this revision with the time of the scene.

        The newest keyframe may be of a robot whose clock is behind: time is that of whoever is
        ahead, so that nothing was seen later than now.
        """
        before_ns = before.stamp_ns if before.epoch == self.epoch else 0
        seen_ns = (one.last_seen_ns for one in changed)
        return replace(self, stamp_ns=max(self.stamp_ns, before_ns, *seen_ns))
