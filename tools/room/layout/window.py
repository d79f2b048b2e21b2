"""A window: an opening with a frame, a sill and what is outside; and its curtain."""

import numpy as np

from sceneq_tools.room.layout.sheets import sheet
from sceneq_tools.room.mesh import Colour, Material, Mesh
from sceneq_tools.room.models.solids import Solid, assembled, box, tube
from sceneq_tools.room.textures import textures
from sceneq_tools.room.textures.pixels import from_hsv

REVEAL_M = 0.16
"""How deep the window sits in the wall."""

FRAME_M = 0.06
"""Width of the frame's bars."""


def window_mesh(rng: np.random.Generator, width_m: float, height_m: float) -> Mesh:
    """Build a window whose lower left corner is at the origin, the wall at y = 0."""
    white = Material((0.88, 0.88, 0.86), shine=0.1, gloss=20)
    brightness = float(rng.uniform(0.85, 1.15))
    outside = Material((1, 1, 1), textures.sky(rng), emission=brightness)
    view = sheet(outside, (0, REVEAL_M, 0), (width_m, 0, 0), (0, 0, height_m))
    parts = [view.tiled(1 / width_m, 1 / height_m), *_reveal(white, width_m, height_m)]
    casements = 2 if width_m > 1.1 else 1
    for i in range(casements + 1):
        x = i * (width_m - FRAME_M) / casements + FRAME_M / 2
        parts.append(box(white, (FRAME_M, 0.05, height_m), (x, 0.125, height_m / 2)))
    level = (width_m, 0.05, FRAME_M)
    parts.append(box(white, level, (width_m / 2, 0.125, FRAME_M / 2)))
    parts.append(box(white, level, (width_m / 2, 0.125, height_m - FRAME_M / 2)))
    return assembled(parts)


def curtain_cloth(rng: np.random.Generator) -> Material:
    """Choose a cloth; the curtains of one room are made of the same."""
    colour: Colour = from_hsv(float(rng.random()), float(rng.uniform(0.05, 0.45)), 0.75)
    return Material((1, 1, 1), textures.fabric(rng, colour))


def curtain_mesh(
    rng: np.random.Generator, cloth: Material, width_m: float, height_m: float
) -> Mesh:
    """Build two drawn-back curtains on a rod, the middle of their foot at the origin.

    Args:
        rng: decides how far they are drawn.
        cloth: what they are made of.
        width_m: of the whole rod; ``height_m``: from the hem to the rod.
        height_m: see there.
    """
    rod = Material((0.35, 0.33, 0.30), shine=0.4, gloss=40)
    half, panel = width_m / 2, width_m * float(rng.uniform(0.16, 0.22))
    parts = [tube(rod, [(-half, 0, height_m), (0, 0, height_m), (half, 0, height_m)], 0.012)]
    for left in (-half + 0.03, half - 0.03 - panel):
        parts += _folds(cloth, left, panel, height_m)
    return assembled(parts)


def _reveal(material: Material, width: float, height: float) -> list[Solid]:
    """Return sill, lintel and sides of the opening."""
    deep = REVEAL_M
    return [
        sheet(material, (0, 0, 0), (width, 0, 0), (0, deep, 0)),
        sheet(material, (0, deep, height), (width, 0, 0), (0, -deep, 0)),
        sheet(material, (0, 0, 0), (0, deep, 0), (0, 0, height)),
        sheet(material, (width, deep, 0), (0, -deep, 0), (0, 0, height)),
    ]


def _folds(cloth: Material, left: float, width: float, height: float) -> list[Solid]:
    """Return hanging cloth in waves, seen from the front."""
    count = max(int(width / 0.02), 8)
    x = np.linspace(left, left + width, count + 1)
    y = 0.025 * np.sin((x - left) / 0.09 * 2 * np.pi)
    strips = []
    for i in range(count):
        corner = (x[i], y[i], 0.0)
        across = (x[i + 1] - x[i], y[i + 1] - y[i], 0.0)
        strips.append(sheet(cloth, corner, across, (0, 0, height)).tiled(3, 3))
    return strips
