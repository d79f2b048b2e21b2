"""How much light falls on the sample points of a stage, and on every place of it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_tools.room.light.stage import Stage
from sceneq_tools.room.room import Light

SMOOTHINGS = 2  # of indirect light, among coarse points: it has few rays and no sharp edges


@dataclass(frozen=True, slots=True, eq=False)
class Illumination:
    """Light at the sample points; axis 0 is front and back.

    Attributes:
        form: float32 (2, P, L) irradiance from each light at radiance 1, shadows included.
        seen: float32 (2, P, L) share of each light that is seen.
        indirect: float32 (2, C, 3) irradiance by way of other surfaces, at coarse points.
        open_fine, open_coarse: float32 (2, P), (2, C) free share of the closest surroundings.
    """

    form: Float32
    seen: Float32
    indirect: Float32
    open_fine: Float32
    open_coarse: Float32


@dataclass(frozen=True, slots=True, eq=False)
class PlaceLight:
    """Light at the places of a stage: rows 0 to N at their fronts, N to 2 N at their backs.

    Attributes:
        irradiance: float32 (2 N, 3); ``seen``: float32 (2 N, L) share of each light.
    """

    irradiance: Float32
    seen: Float32


def dark(stage: Stage, lights: int) -> Illumination:
    """Return no light at all."""
    fine, coarse = len(stage.fine.positions), len(stage.coarse.positions)
    return Illumination(
        np.zeros((2, fine, lights), np.float32),
        np.zeros((2, fine, lights), np.float32),
        np.zeros((2, coarse, 3), np.float32),
        np.zeros((2, fine), np.float32),
        np.zeros((2, coarse), np.float32),
    )


def at_places(light: Illumination, stage: Stage, lights: Sequence[Light]) -> PlaceLight:
    """Spread the light at sample points over all places."""
    direct = light.form @ radiances(lights)
    measured = np.concatenate([direct, light.seen], axis=2)
    count = int(stage.place_starts[-1])
    irradiance = np.zeros((2, count, 3), np.float32)
    seen = np.zeros((2, count, len(lights)), np.float32)
    for k, mesh in enumerate(stage.meshes):
        fine, coarse, here = (
            slice(starts[k], starts[k + 1])
            for starts in (stage.fine.starts, stage.coarse.starts, stage.place_starts)
        )
        for side in range(2 if stage.fine.two_sided[fine].any() else 1):
            open_fine = light.open_fine[side, fine]
            even = _evened(mesh.fine.smoothing, measured[side, fine], open_fine)
            near = _read(mesh.fine.blend, even, open_fine)
            open_coarse = light.open_coarse[side, coarse]
            smooth = light.indirect[side, coarse]
            for _ in range(SMOOTHINGS):
                smooth = _read(mesh.coarse.smoothing, smooth, open_coarse)
            far = _read(mesh.coarse.blend, smooth, open_coarse)
            irradiance[side, here] = near[:, :3] + far
            seen[side, here] = near[:, 3:]
    return PlaceLight(irradiance.reshape(-1, 3), seen.reshape(2 * count, len(lights)))


def _evened(smoothing: Any, measured: Float32, openness: Float32) -> Float32:
    """Smooth where a light is half seen: there, few rays are noisy and the truth is smooth."""
    seen = measured[:, 3:]
    half = ((seen > 0) & (seen < 1)).any(axis=1, keepdims=True)
    return np.where(half, _read(smoothing, measured, openness), measured)


def _read(blend: Any, values: Float32, openness: Float32) -> Float32:
    """Average values (P, C) so that points in hidden gaps do not darken what is beside them."""
    trust = (openness**3 + np.float32(1e-5))[:, None]
    read: Float32 = (blend @ (values * trust)) / (blend @ trust)
    return read


def radiances(lights: Sequence[Light]) -> Float32:
    """Return float32 (L, 3)."""
    return np.array([light.radiance for light in lights], np.float32).reshape(-1, 3)
