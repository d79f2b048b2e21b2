"""What a hand that holds a camera adds to the way it goes: drift, tremor, steps."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_tools.room.camera.pace import STEEPEST

WAVES = 5
STEP_M = 0.65


@dataclass(frozen=True, slots=True)
class TremorParams:
    """Largest deflections, in metres and degrees, and the bands of their waves in hertz.

    Arms sway below 1 Hz by centimetres; physiological tremor lies between 4 and 12 Hz but a held
    camera's mass damps most of it, what is left is fractions of a millimetre (Elble and Koller,
    Tremor, 1990). A walking head rises and falls by about 2 cm a step.
    """

    sway_m: float = 0.020
    sway_deg: float = 1.2
    sway_hz: tuple[float, float] = (0.10, 0.60)
    tremor_m: float = 0.0008
    tremor_deg: float = 0.10
    tremor_hz: tuple[float, float] = (2.0, 6.0)
    bob_m: float = 0.018
    roll_deg: float = 0.6

    def __post_init__(self) -> None:
        for name in ("sway_m", "sway_deg", "tremor_m", "tremor_deg", "bob_m", "roll_deg"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name}: expected 0 or more, got {getattr(self, name)}")
        for name in ("sway_hz", "tremor_hz"):
            low, high = getattr(self, name)
            if not 0 < low <= high:
                raise ValueError(f"{name}: expected 0 < low <= high, got {low}, {high}")


class HandTremor:
    """Sums of a few sines: band-limited, bounded, and known at any time."""

    def __init__(self, rng: np.random.Generator, params: TremorParams | None = None) -> None:
        """Draw frequencies and phases."""
        self._params = params or TremorParams()
        self._sway = _Waves(rng, self._params.sway_hz)
        self._tremor = _Waves(rng, self._params.tremor_hz)

    def at(self, time_s: float, walked_m: float, speed: float) -> tuple[Float64, Float64]:
        """Return the offset (3,) right, down, forward in metres and a rotation vector (3,).

        ``speed`` is 0 standing to 1 at full pace: steps fade with it.
        """
        p = self._params
        sway, tremor = self._sway.at(time_s), self._tremor.at(time_s)
        offset_m = p.sway_m * sway[:3] + p.tremor_m * tremor[:3]
        turn = np.radians(p.sway_deg * sway[3:] + p.tremor_deg * tremor[3:])
        step = np.pi * walked_m / STEP_M
        offset_m[1] -= p.bob_m * speed * np.sin(step) ** 2
        turn[2] += np.radians(p.roll_deg) * speed * np.sin(step)
        return offset_m, turn

    def top_speed(self, walk_m_s: float, ramp_s: float) -> tuple[float, float]:
        """Return no less than the fastest it moves and turns, m/s and rad/s, at this pace."""
        p = self._params
        sway, tremor = self._sway.top_speed(), self._tremor.top_speed()
        steps = np.pi * walk_m_s / STEP_M + STEEPEST / ramp_s
        moves = p.sway_m * sway[:3] + p.tremor_m * tremor[:3]
        turns = np.radians(p.sway_deg * sway[3:] + p.tremor_deg * tremor[3:])
        move = np.linalg.norm(moves) + p.bob_m * steps
        return float(move), float(np.linalg.norm(turns) + np.radians(p.roll_deg) * steps)


class _Waves:
    """Six independent signals, each within -1 to 1."""

    def __init__(self, rng: np.random.Generator, band_hz: tuple[float, float]) -> None:
        low, high = np.log(band_hz)
        self._omega = 2 * np.pi * np.exp(rng.uniform(low, high, (6, WAVES)))
        self._phase = rng.uniform(0, 2 * np.pi, (6, WAVES))

    def at(self, time_s: float) -> Float64:
        return np.asarray(np.sin(self._omega * time_s + self._phase).mean(axis=1))

    def top_speed(self) -> Float64:
        return np.asarray(self._omega.mean(axis=1))
