"""Surfaces painted by numbers: floors, walls, cloth, wood, windows. All sRGB + alpha, uint8.

Each is a function of a random generator, so that a seed decides what it looks like, and repeats
without a seam except ``sky``. Pictures for frames are in ``paintings``, carpets in ``rugs``.
"""

import numpy as np
import numpy.typing as npt

from sceneq_core.arrays import Float64, UInt8
from sceneq_tools.room.mesh import Colour
from sceneq_tools.room.textures.noise import fractal_noise, spread
from sceneq_tools.room.textures.paintings import painting
from sceneq_tools.room.textures.pixels import coordinates, opaque
from sceneq_tools.room.textures.rugs import rug

__all__ = [
    "carpet",
    "fabric",
    "painting",
    "planks",
    "plaster",
    "rug",
    "sky",
    "tiles",
    "wallpaper",
    "wood",
]

WALLPAPERS = ("stripes", "diamonds", "dots", "scales")


def planks(
    rng: np.random.Generator,
    colour: Colour = (0.62, 0.45, 0.30),
    boards: int = 8,
    size_px: int = 1024,
) -> UInt8:
    """A floor of ``boards`` boards side by side along u, two lengths each, ends staggered."""
    high, long = size_px // boards, size_px // 2
    rows = []
    for _ in range(boards):
        row = np.concatenate([_board(rng, colour, high, long) for _ in range(2)], axis=1)
        rows.append(np.roll(row, int(rng.integers(size_px)), axis=1))
    return opaque(np.concatenate(rows))


def _board(rng: np.random.Generator, colour: Colour, high: int, long: int) -> Float64:
    tone = np.array(colour) * rng.uniform(0.82, 1.12) * (1 + rng.normal(0, 0.008, 3))
    board = tone * _grain(rng, (high, long), (2, 1), rings=9.0)[..., None]
    edge = np.ones((high, long))
    edge[[0, -1]], edge[:, [0, -1]] = 0.62, 0.66
    return np.asarray(board * edge[..., None])


def _grain(
    rng: np.random.Generator, shape: tuple[int, int], cells: tuple[int, int], rings: float
) -> Float64:
    """Wood grain along u: a factor around 1."""
    broad = fractal_noise(rng, shape, cells, octaves=4)
    fine = fractal_noise(rng, shape, (min(shape[0], 48), 3), octaves=2)
    ring = 0.5 + 0.5 * np.sin(2 * np.pi * rings * broad)
    return 1.0 + 0.16 * (broad - 0.5) + 0.10 * (fine - 0.5) - 0.08 * ring**3


def wood(
    rng: np.random.Generator,
    colour: Colour = (0.60, 0.43, 0.28),
    height_px: int = 256,
    width_px: int = 512,
) -> UInt8:
    """Plain wood, grain along u."""
    grain = _grain(rng, (height_px, width_px), (3, 1), rings=12.0)
    return opaque(np.array(colour) * grain[..., None])


def tiles(
    rng: np.random.Generator,
    colour: Colour = (0.80, 0.79, 0.76),
    count: int = 4,
    grout: Colour = (0.58, 0.57, 0.54),
    size_px: int = 768,
) -> UInt8:
    """``count`` x ``count`` tiles with joints, each a little different."""
    side = size_px // count
    square = [[_tile(rng, colour, side) for _ in range(count)] for _ in range(count)]
    image = np.concatenate([np.concatenate(row, axis=1) for row in square])
    at = np.arange(side * count) % side
    joint = (at < 2) | (at >= side - 2)
    image[joint], image[:, joint] = grout, grout
    return opaque(image)


def _tile(rng: np.random.Generator, colour: Colour, side: int) -> Float64:
    cloud = fractal_noise(rng, (side, side), (3, 3), octaves=5)
    tone = np.array(colour) * rng.uniform(0.95, 1.04)
    return np.asarray(tone * (1 + 0.09 * (cloud[..., None] - 0.5)))


def plaster(
    rng: np.random.Generator, colour: Colour = (0.90, 0.89, 0.86), size_px: int = 512
) -> UInt8:
    """A painted wall: almost even, so that it does not look like plastic."""
    cloud = fractal_noise(rng, (size_px, size_px), (4, 4), octaves=7, gain=0.6)
    speck = rng.normal(0.0, 0.008, (size_px, size_px))
    return opaque(np.array(colour) * (1 + 0.04 * (cloud - 0.5) + speck)[..., None])


def wallpaper(
    rng: np.random.Generator,
    colour: Colour = (0.82, 0.80, 0.72),
    pattern: str = "stripes",
    size_px: int = 512,
) -> UInt8:
    """A faint pattern, ``pattern`` one of ``WALLPAPERS``; eight repeats across.

    Raises:
        ValueError: unknown pattern.
    """
    if pattern not in WALLPAPERS:
        raise ValueError(f"no wallpaper {pattern!r}; there are {', '.join(WALLPAPERS)}")
    v, u = coordinates(size_px, size_px)
    mask = _motif(pattern, (u * 8) % 1, (v * 8) % 1)
    cloud = fractal_noise(rng, (size_px, size_px), (8, 8), octaves=6, gain=0.6)
    return opaque(np.array(colour) * (1 - 0.11 * mask + 0.04 * (cloud - 0.5))[..., None])


def _motif(pattern: str, u: Float64, v: Float64) -> Float64:
    if pattern == "stripes":
        return _soft(0.25 - np.abs(u - 0.5))
    if pattern == "diamonds":
        return _soft(0.30 - np.abs(u - 0.5) - np.abs(v - 0.5))
    if pattern == "dots":
        return _soft(0.2 - np.hypot(u - 0.5, v - 0.5))
    return _soft(0.04 - np.abs(np.hypot(u - 0.5, v) - 0.45))


def _soft(distance: Float64) -> Float64:
    """1 inside, 0 outside, over a few pixels."""
    return np.clip(distance / 0.03 + 0.5, 0.0, 1.0)


def fabric(
    rng: np.random.Generator, colour: Colour = (0.55, 0.55, 0.58), size_px: int = 256
) -> UInt8:
    """Plain weave, 64 threads across."""
    v, u = coordinates(size_px, size_px)
    warp, weft = np.sin(2 * np.pi * 64 * u), np.sin(2 * np.pi * 64 * v)
    weave = np.where(np.sin(2 * np.pi * 32 * u) * np.sin(2 * np.pi * 32 * v) > 0, warp, weft)
    cloud = fractal_noise(rng, (size_px, size_px), (4, 4), octaves=6)
    thread = rng.normal(0.0, 0.02, (size_px, size_px))
    return opaque(np.array(colour) * (1 + 0.05 * weave + 0.12 * (cloud - 0.5) + thread)[..., None])


def carpet(
    rng: np.random.Generator, colour: Colour = (0.60, 0.58, 0.54), size_px: int = 512
) -> UInt8:
    """Short pile from wall to wall."""
    pile = fractal_noise(rng, (size_px, size_px), (64, 64), octaves=3)
    speck = rng.normal(0.0, 0.05, (size_px, size_px))
    return opaque(np.array(colour) * (1 + 0.25 * (pile - 0.5) + speck)[..., None])


def sky(rng: np.random.Generator, height_px: int = 384, width_px: int = 512) -> UInt8:
    """What is outside a window: sky with clouds, a far hill, trees, a lawn."""
    shape = (height_px, width_px)
    height = 1 - coordinates(*shape)[0]
    image = _blend((0.90, 0.94, 0.98), (0.42, 0.63, 0.92), np.clip(height * 1.4 - 0.5, 0, 1))
    cloud = np.clip(spread(fractal_noise(rng, shape, (4, 3), octaves=6)) - 0.52, 0, 1) * 2.2
    image = _over(image, (0.98, 0.98, 0.99), np.clip(cloud, 0, 0.9))
    for base, rough, colour, cells in _HILLS:
        ridge = base + rough * (fractal_noise(rng, (1, width_px), (1, cells), octaves=6)[0] - 0.5)
        leaves = 0.65 + 0.7 * fractal_noise(rng, shape, (24, 32), octaves=4)
        image = np.where((height < ridge)[..., None], np.array(colour) * leaves[..., None], image)
    return opaque(image)


_HILLS = (
    (0.45, 0.15, (0.52, 0.62, 0.66), 3),
    (0.38, 0.22, (0.30, 0.44, 0.24), 8),
    (0.24, 0.05, (0.38, 0.54, 0.24), 2),
)


def _blend(low: Colour, high: Colour, share: Float64) -> Float64:
    return np.asarray(np.array(low) * (1 - share[..., None]) + np.array(high) * share[..., None])


def _over(image: Float64, colour: Colour, share: npt.NDArray[np.float64]) -> Float64:
    return np.asarray(image * (1 - share[..., None]) + np.array(colour) * share[..., None])
