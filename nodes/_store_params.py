"""What the durability of a map may cost."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class StoreParams:
    """What durability may cost.

    A checkpoint is due after ``replay_s`` seconds of integrating, which is what a recovery takes
    at most, and writing them takes at most this ``share`` of the time; ``keep`` of them stay. The
    journal keeps everything since the first frame as long as it is below ``max_mb``, beyond that
    what the oldest checkpoint needs.
    """

    replay_s: float = 3.0
    share: float = 0.1
    keep: int = 2
    max_mb: float = 2048.0

    def __post_init__(self) -> None:
        if not self.replay_s >= 0:
            raise ValueError(f"replay_s: must be at least 0, got {self.replay_s}")
        if not 0 < self.share <= 1:
            raise ValueError(f"share: {self.share} is not in (0, 1]")
        if self.keep < 1:
            raise ValueError(f"keep: must be at least 1, got {self.keep}")
        if not self.max_mb > 0:
            raise ValueError(f"max_mb: must be more than 0, got {self.max_mb}")
