"""A painting in its frame."""

import numpy as np

from sceneq_tools.room.mesh import Colour, Material, Mesh
from sceneq_tools.room.models.solids import Solid, assembled, box, picture
from sceneq_tools.room.textures.paintings import painting

FRAMES: tuple[Colour, ...] = (
    (0.10, 0.09, 0.08),
    (0.48, 0.32, 0.18),
    (0.86, 0.85, 0.82),
    (0.70, 0.56, 0.28),
)
DEEP_M = 0.025
BAR_M = 0.03


def framed_painting(rng: np.random.Generator, width_m: float, height_m: float) -> Mesh:
    """Build a painting for a wall at y = 0, the middle of its lower edge at the origin."""
    frame = Material(FRAMES[int(rng.integers(len(FRAMES)))], shine=0.2, gloss=20)
    pixels = 512 / max(width_m, height_m)
    image = painting(rng, height_px=int(height_m * pixels), width_px=int(width_m * pixels))
    canvas = Material((1, 1, 1), image)
    passe = Material((0.93, 0.92, 0.89))
    inner = (width_m - 2 * BAR_M, height_m - 2 * BAR_M)
    mount = float(rng.choice([0.0, 0.0, 0.05])) if min(inner) > 0.3 else 0.0
    middle = (0.0, -0.014, height_m / 2)
    shown = (inner[0] - 2 * mount, inner[1] - 2 * mount)
    return assembled(
        [
            *_bars(frame, width_m, height_m),
            picture(passe, *inner, (0.0, -0.012, height_m / 2)),
            picture(canvas, *shown, middle),
        ]
    )


def _bars(frame: Material, width: float, height: float) -> list[Solid]:
    half, deep = BAR_M / 2, -DEEP_M / 2
    upright, level = (BAR_M, DEEP_M, height), (width, DEEP_M, BAR_M)
    return [
        box(frame, upright, (-width / 2 + half, deep, height / 2)),
        box(frame, upright, (width / 2 - half, deep, height / 2)),
        box(frame, level, (0.0, deep, half)),
        box(frame, level, (0.0, deep, height - half)),
    ]
