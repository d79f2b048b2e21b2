"""Ceiling lamps."""

import numpy as np

from sceneq_tools.room.mesh import Material, Mesh
from sceneq_tools.room.models.solids import assembled, box, cylinder, lathe

LAMP_DROP_M = 0.28
"""From the ceiling to the lower edge of a lamp."""

GLOW = 2.2
"""Brightness of the shade itself."""


def ceiling_lamp_mesh(rng: np.random.Generator) -> Mesh:
    """Build a lamp whose lower edge is at z = 0 and which reaches up to the ceiling."""
    glass = Material((1.0, 0.95, 0.86), emission=GLOW)
    metal = Material((0.55, 0.53, 0.50), shine=0.4, gloss=40)
    shape = int(rng.integers(3))
    rod = cylinder(metal, 0.012, LAMP_DROP_M - 0.08, (0, 0, 0.08))
    rose = cylinder(metal, 0.06, 0.03, (0, 0, LAMP_DROP_M - 0.03))
    if shape == 0:
        shade = box(glass, (0.6, 0.6, 0.06), (0, 0, 0.05))
    elif shape == 1:
        shade = lathe(glass, [(0, 0.0), (0.12, 0.01), (0.2, 0.05), (0.22, 0.1), (0, 0.12)])
    else:
        shade = cylinder(glass, 0.26, 0.14, (0, 0, 0.0))
    return assembled([shade, rod, rose])
