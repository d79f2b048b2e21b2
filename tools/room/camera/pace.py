"""How fast a camera is carried, and how it gets from rest to rest without a jerk."""

from dataclasses import dataclass

STEEPEST = 1.5
"""The steepest slope of the ramp ``3 u^2 - 2 u^3`` over u in 0..1."""


@dataclass(frozen=True, slots=True)
class Pace:
    """Limits that hold for the whole movement, tremor included.

    Indoors people stroll at 0.5 to 0.8 m/s with a camera, and turn it at 30 to 60 degrees a
    second when the pictures shall be sharp. ``ramp_s`` is the time to get to full speed;
    ``dwell_s`` how long a look at a place lasts.
    """

    walk_m_s: float = 0.9
    turn_deg_s: float = 70.0
    ramp_s: float = 0.5
    dwell_s: float = 1.0

    def __post_init__(self) -> None:
        for name in ("walk_m_s", "turn_deg_s", "ramp_s"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name}: expected more than 0, got {getattr(self, name)}")
        if self.dwell_s < 0:
            raise ValueError(f"dwell_s: expected 0 or more, got {self.dwell_s}")


@dataclass(frozen=True, slots=True)
class Glide:
    """From 0 to 1 in ``duration_s``, at rest at both ends, the acceleration without jumps."""

    duration_s: float
    ramp_s: float

    @classmethod
    def within(cls, ramp_s: float, *needs: tuple[float, float]) -> "Glide":
        """Return the quickest glide over each (length, greatest speed) of ``needs``."""
        cruise_s = max(length / speed for length, speed in needs)
        return cls(ramp_s + max(cruise_s, ramp_s), ramp_s)

    def speed(self, time_s: float) -> float:
        """Return the speed as a part of its greatest, 0 to 1."""
        from_rest_s = min(time_s, self.duration_s - time_s)
        u = min(max(from_rest_s / self.ramp_s, 0.0), 1.0)
        return u * u * (3 - 2 * u)

    def progress(self, time_s: float) -> float:
        """Return how much of the way is done at ``time_s``, 0 to 1."""
        if time_s > self.duration_s / 2:
            return 1.0 - self.progress(self.duration_s - time_s)
        u = min(max(time_s / self.ramp_s, 0.0), 1.0)
        ramp = self.ramp_s * (u**3 - u**4 / 2)
        return (ramp + max(time_s - self.ramp_s, 0.0)) / (self.duration_s - self.ramp_s)
