"""Highlights: the lights' mirror images on what is not quite dull."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_tools.room.light.illumination import radiances
from sceneq_tools.room.light.vectors import dot, length
from sceneq_tools.room.room import Light

DULL = 0.04  # weaker highlights are not computed
SOFTEST = 4.0
SHARPEST = 64.0  # larger exponents make a highlight smaller than the lamp it mirrors
NEAREST_M = 0.2  # a light's centre counts as no nearer than this


@dataclass(frozen=True, slots=True, eq=False)
class Lamps:
    """The lights as highlights see them.

    Attributes: float32 (L, 3) ``centres`` and ``power`` (radiance times area).
    """

    centres: Float32
    power: Float32


@dataclass(frozen=True, slots=True, eq=False)
class Glances:
    """Places on surfaces and how they are looked at.

    Attributes:
        at: float32 (3, N) world; ``out``: float32 (3, N) unit, to the camera.
        normals: float32 (3, N) to the side that is seen, of any length.
        seen: float32 (L, N) share of each light that is seen from there.
    """

    at: Float32
    out: Float32
    normals: Float32
    seen: Float32


def lamps(lights: Sequence[Light]) -> Lamps:
    """Return centres and powers of rectangles."""
    centres = [light.corner + (light.edge_u + light.edge_v) / 2 for light in lights]
    areas = [np.linalg.norm(np.cross(light.edge_u, light.edge_v)) for light in lights]
    power = radiances(lights) * np.array(areas, np.float32)[:, None]
    return Lamps(np.array(centres, np.float32).reshape(-1, 3), power)


def highlights(lights: Lamps, glances: Glances, shine: Float32, gloss: Float32) -> Float32:
    """Return radiance (3, N): Blinn-Phong at the lights' centres, as far as each light is seen."""
    normals = glances.normals
    steepness: Float32 = np.divide(1, length(normals))
    viewed: Float32 = dot(normals, glances.out) * steepness
    sharp = np.clip(gloss, SOFTEST, SHARPEST)
    strength = shine * (sharp + 2) * np.float32(0.35 / (8 * np.pi))
    strength[shine <= DULL] = 0
    total = np.zeros_like(glances.at)
    for centre, power, seen in zip(lights.centres, lights.power, glances.seen, strict=True):
        if seen.any():
            lobe = _lobe(centre, glances, steepness, viewed, sharp)
            total += lobe * (strength * seen) * power[:, None]
    return total


def _lobe(
    centre: Float32, glances: Glances, steepness: Float32, viewed: Float32, gloss: Float32
) -> Float32:
    """Return one light's lobe (N,).

    The normal's product with the half vector follows from those with its two parts, since the
    length of a sum of unit vectors a + b is sqrt(2 + 2 a.b): no vector has to be scaled.
    """
    to_light = centre[:, None] - glances.at
    squared = dot(to_light, to_light)
    scale = np.divide(1, length(to_light))
    arriving = dot(to_light, glances.normals) * steepness * scale
    between = dot(to_light, glances.out) * scale
    half = np.sqrt(np.maximum(2 + 2 * between, np.float32(1e-6)))
    near = np.maximum((arriving + viewed) / half, np.float32(1e-6))
    lobe: Float32 = np.exp(gloss * np.log(near)) * np.maximum(arriving, 0)
    lobe /= np.maximum(squared, np.float32(NEAREST_M**2))
    return lobe
