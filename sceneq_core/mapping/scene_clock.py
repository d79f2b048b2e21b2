"""The time of a scene whose robots' clocks need not agree."""

from sceneq_core.visits import visit_of


class SceneClock:
    """Runs from the stamps of keyframes, and never back.

    Within a visit stamps tell how much time went by; between visits they may not compare: clocks
    are off, and a recording is played when it is long over. Where a visit's stamps lag behind, time
    goes on with those of whoever is ahead, and with its own while no other one moves it. So what
    only the robot sees whose clock is behind is seen for as long as it is. Of a single visit it is
    the largest stamp so far.

    Attributes:
        now_ns: the time.
    """

    def __init__(self) -> None:
        self.now_ns = 0
        self._last_of: dict[int, tuple[int, int]] = {}

    def tick(self, seq: int, stamp_ns: int) -> int:
        """Return the time of keyframe ``seq`` of the scene, nanoseconds."""
        visit = visit_of(seq)
        largest_ns, then_ns = self._last_of.get(visit, (stamp_ns, self.now_ns))
        passed_ns = max(0, stamp_ns - largest_ns) if then_ns == self.now_ns else 0
        self.now_ns = max(self.now_ns + passed_ns, stamp_ns)
        self._last_of[visit] = max(largest_ns, stamp_ns), self.now_ns
        return self.now_ns
