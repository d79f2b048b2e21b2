"""A closed door in its frame."""

import numpy as np

from sceneq_tools.room.mesh import Material, Mesh
from sceneq_tools.room.models.solids import assembled, box
from sceneq_tools.room.textures import textures

DOOR_M = (0.95, 2.1)
"""Width and height with the frame."""

SHADES = ((0.88, 0.87, 0.84), (0.62, 0.44, 0.28), (0.42, 0.28, 0.18), (0.76, 0.66, 0.52))


def door_mesh(rng: np.random.Generator) -> Mesh:
    """Build a door whose lower left corner is at the origin, the wall at y = 0."""
    shade = SHADES[int(rng.integers(len(SHADES)))]
    leaf = Material((1, 1, 1), textures.wood(rng, shade), shine=0.1, gloss=20)
    panel = Material((0.92, 0.92, 0.92), leaf.texture, shine=0.1, gloss=20)
    white = Material((0.88, 0.88, 0.86), shine=0.1, gloss=20)
    metal = Material((0.70, 0.66, 0.55), shine=0.5, gloss=50)
    width, height = DOOR_M
    middle = width / 2
    parts = [
        box(white, (0.07, 0.04, height), (0.035, -0.02, height / 2)),
        box(white, (0.07, 0.04, height), (width - 0.035, -0.02, height / 2)),
        box(white, (width, 0.04, 0.07), (middle, -0.02, height - 0.035)),
        box(leaf, (width - 0.14, 0.02, height - 0.07), (middle, -0.01, (height - 0.07) / 2)),
        box(metal, (0.12, 0.015, 0.02), (width - 0.18, -0.06, 1.02)),
        box(metal, (0.02, 0.05, 0.02), (width - 0.13, -0.04, 1.02)),
    ]
    for low, high in ((0.18, 0.90), (1.15, 1.90)):
        size = (width - 0.40, 0.008, high - low)
        parts.append(box(panel, size, (middle, -0.024, (low + high) / 2)))
    return assembled(parts)
