"""What to do with a source that comes into a scene."""

from dataclasses import dataclass, field

from sceneq_core.checks import need_at_least
from sceneq_core.places.relocaliser import RelocaliserParams

RELOCALISE, SAME_FRAME = "relocalise", "same_frame"
STARTS = (RELOCALISE, SAME_FRAME)


@dataclass(frozen=True, slots=True)
class ArrivalParams:
    """What to do where the map has frames of other sources already.

    ``start``: ``same_frame``, the poses lie in the map's frame of reference, or ``relocalise``.
    Until that has succeeded the newest ``hold`` keyframes wait, about 1 MB each on disk; then
    ``release_hz`` of them follow each second, or as fast as the graph takes them where nothing is
    to be lost. Places are asked for again after ``look_again_s``: another robot's map may grow.

    An answer that further keyframes would still change is gone by when none came for ``settle_s``.

    With a store, ``visits`` that were not placed are kept, the newest ones. Looking for the places
    of those left behind may take this ``share`` of the time; another robot's are taken along when
    nothing was written to them for ``quiet_s``.
    """

    start: str = "relocalise"
    hold: int = 300
    release_hz: float = 3.0
    settle_s: float = 2.0
    look_again_s: float = 2.0
    visits: int = 8
    share: float = 0.2
    quiet_s: float = 30.0
    relocaliser: RelocaliserParams = field(default_factory=RelocaliserParams)

    def __post_init__(self) -> None:
        if self.start not in STARTS:
            raise ValueError(f"start: expected {' or '.join(STARTS)}, got {self.start!r}")
        need_at_least(self, 1, "hold", "visits")
        need_at_least(self, 0.1, "release_hz")
        need_at_least(self, 0, "look_again_s", "settle_s", "quiet_s")
        if not 0 < self.share <= 1:
            raise ValueError(f"share: {self.share} is not in (0, 1]")
