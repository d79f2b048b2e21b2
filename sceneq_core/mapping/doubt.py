"""Doubt in an instance: its place is looked at, and it is not there as it was."""

from dataclasses import dataclass

from sceneq_core.checks import need_at_least, need_between
from sceneq_core.mapping.delta import Instance


@dataclass(frozen=True, slots=True)
class DoubtParams:
    """When the looks through an instance count against all of it.

    A keyframe raises doubt when it looks through ``min_share`` of the voxels it tests, and those
    are ``min_part`` of the instance. After ``min_views`` such keyframes over ``min_s`` seconds an
    instance of which ``min_share`` is not there is stale. It is decided when ``gone_share`` of it
    has been cleared: ``kept_share`` still seen means that the rest of it stays, as much new surface
    that it moved, neither that all of it is gone. Doubt ends when after ``min_s`` without another
    such keyframe ``gone_share`` of what is left was seen.
    """

    min_share: float = 0.3
    min_part: float = 0.1
    min_views: int = 2
    min_s: float = 0.25
    gone_share: float = 0.5
    kept_share: float = 0.3

    def __post_init__(self) -> None:
        need_between(self, 0, 1, "min_share", "min_part", "gone_share", "kept_share")
        need_at_least(self, 1, "min_views")
        need_at_least(self, 0, "min_s")

    def raised(self, seen: int, through: int, size: int) -> bool:
        """Tell whether one keyframe contradicts an instance of ``size`` voxels."""
        tested = seen + through
        return through >= self.min_share * tested and tested >= self.min_part * size > 0


@dataclass(slots=True)
class Doubt:
    """The looks through an instance since ``began_ns``; ``before`` is how it was until then."""

    began_ns: int
    before: Instance
    last_ns: int = 0
    views: int = 0
    missing: int = 0
    lost: int = 0

    @property
    def size(self) -> int:
        """The number of voxels it had."""
        return self.before.voxel_count

    def add(self, through: int, lost: int, now_ns: int) -> None:
        """Add a keyframe that contradicts the instance."""
        self.views += 1
        self.last_ns = now_ns
        self.missing = max(self.missing, self.lost + through)
        self.lost += lost

    def is_stale(self, params: DoubtParams) -> bool:
        """Tell whether a part of the instance is not there, for all that is known."""
        lasted = self.last_ns - self.began_ns >= params.min_s * 1e9
        enough = self.views >= params.min_views and lasted
        return enough and self.missing >= params.min_share * self.size

    def is_decided(self, params: DoubtParams) -> bool:
        """Tell whether enough of the instance was cleared to say what happened to it."""
        return self.lost >= params.gone_share * self.size
