"""Measuring light where it is not known yet."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float32, Int32
from sceneq_tools.room.light.direct_light import direct_light, receivers
from sceneq_tools.room.light.illumination import Illumination, radiances
from sceneq_tools.room.light.indirect_light import Views, indirect_light, openness, views
from sceneq_tools.room.light.quality import Quality
from sceneq_tools.room.light.raycaster import Raycaster
from sceneq_tools.room.light.stage import Points, Stage
from sceneq_tools.room.room import Light

BLOCK = 150_000  # receivers at once: bounds the memory of their rays

GAP_M = 0.03  # what is closer than this on all sides is a gap that nobody looks into
WIDE_GAP_M = 0.10  # the same for coarse points: light caught behind a curtain stays there


@dataclass(frozen=True, slots=True, eq=False)
class Stale:
    """Points whose light is not known (any more).

    Attributes:
        fine: bool (P,) whose surroundings may be closed in now; ``direct``: bool (P, L) by light.
        coarse: bool (C,).
    """

    fine: Bool
    direct: Bool
    coarse: Bool


def everything(light: Illumination) -> Stale:
    """Return that nothing is known."""
    parts = (light.open_fine, light.form, light.open_coarse)
    return Stale(*(np.ones(part.shape[1:], bool) for part in parts))


@dataclass(frozen=True, slots=True, eq=False)
class LightMeter:
    """Casts the rays from surfaces to lights and to each other."""

    stage: Stage
    lights: Sequence[Light]
    raycaster: Raycaster
    quality: Quality
    seed: int

    def measure(self, light: Illumination, stale: Stale) -> None:
        """Fill in ``light``, in place: free surroundings, direct light, then some bounces."""
        self._measure_openness(light.open_fine, self.stage.fine, stale.fine, GAP_M)
        self._measure_openness(light.open_coarse, self.stage.coarse, stale.coarse, WIDE_GAP_M)
        for k, lamp in enumerate(self.lights):
            self._measure_direct(light, k, lamp, stale.direct[:, k])
        around = self._look_around(stale.coarse, light.open_coarse)
        direct = _at_coarse(light.form @ radiances(self.lights), self.stage)
        for _ in range(self.quality.bounces):
            irradiance = direct + light.indirect
            for side, index, seen in around:
                light.indirect[side, index] = indirect_light(seen, self.stage, irradiance)

    def _measure_openness(self, free: Float32, points: Points, stale: Bool, gap_m: float) -> None:
        for side, index in _blocks(points, stale):
            to = receivers(points, index, side, self.seed)
            free[side, index] = openness(to, self.raycaster, gap_m)

    def _measure_direct(self, light: Illumination, k: int, lamp: Light, stale: Bool) -> None:
        light.form[:, stale, k] = light.seen[:, stale, k] = 0
        for side, index in _blocks(self.stage.fine, stale):
            free = index[light.open_fine[side, index] > 0]
            to = receivers(self.stage.fine, free, side, self.seed)
            form, seen = direct_light(to, lamp, self.raycaster, self.quality.shadow_rays)
            light.form[side, free, k], light.seen[side, free, k] = form, seen

    def _look_around(self, stale: Bool, free: Float32) -> list[tuple[int, Int32, Views]]:
        found = []
        for side, index in _blocks(self.stage.coarse, stale):
            there = index[free[side, index] > 0]
            to = receivers(self.stage.coarse, there, side, self.seed + 1)
            found.append((side, there, views(to, self.raycaster, self.quality.gather_rays)))
        return found


def _blocks(points: Points, stale: Bool) -> list[tuple[int, Int32]]:
    """Return (side, indices) of all stale points, not too many at once."""
    blocks = []
    for side, wanted in enumerate((stale, stale & points.two_sided)):
        index = np.flatnonzero(wanted).astype(np.int32)
        blocks += [(side, part) for part in np.split(index, range(BLOCK, len(index), BLOCK))]
    return [(side, index) for side, index in blocks if len(index)]


def _at_coarse(values: Float32, stage: Stage) -> Float32:
    """Average (2, P, 3) at fine points over the faces of each coarse point: (2, C, 3)."""
    of, count = stage.coarse_of_face, len(stage.coarse.positions)
    members = np.maximum(np.bincount(of, minlength=count), 1)[:, None]
    sides = [
        np.stack([np.bincount(of, column, count) for column in side[stage.fine_of_face].T], axis=1)
        for side in values
    ]
    return (np.stack(sides) / members).astype(np.float32)
