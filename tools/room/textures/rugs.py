"""Woven carpets: a field, a pattern on it and a border."""

import numpy as np

from sceneq_core.arrays import Float64, UInt8
from sceneq_tools.room.mesh import Colour
from sceneq_tools.room.textures.noise import fractal_noise
from sceneq_tools.room.textures.pixels import coordinates, from_hsv, opaque

RUGS = ("stripes", "diamonds", "medallion", "plain", "zigzag")


def rug(
    rng: np.random.Generator,
    style: str | None = None,
    colour: Colour | None = None,
    height_px: int = 384,
    width_px: int = 576,
) -> UInt8:
    """Weave a rug, in a style of ``RUGS`` or in any, around a main colour.

    Raises:
        ValueError: unknown style.
    """
    if style is None:
        style = RUGS[int(rng.integers(len(RUGS)))]
    if style not in RUGS:
        raise ValueError(f"no rug {style!r}; there are {', '.join(RUGS)}")
    if colour is None:
        hue = float(rng.choice([0.0, 0.04, 0.10, 0.30, 0.55, 0.62]))
        colour = from_hsv(hue, 0.55, rng.uniform(0.4, 0.7))
    down, right = coordinates(height_px, width_px)
    y, x = down * height_px / width_px, right
    yarns = np.array([colour, *_yarns(rng, colour)])
    which = _pattern(style, y - y.max() / 2, x - 0.5)
    edge = np.minimum(np.minimum(x, 1 - x), np.minimum(y, y.max() - y))
    if style != "stripes":
        which = np.where(edge < 0.075, 2, which)
        which = np.where((edge > 0.035) & (edge < 0.055), 1, which)
    return opaque(yarns[which] * _pile(rng, (height_px, width_px))[..., None])


def _yarns(rng: np.random.Generator, colour: Colour) -> list[Colour]:
    """A light, a dark and a lively yarn that go with the main colour."""
    dark = (colour[0] * 0.45, colour[1] * 0.45, colour[2] * 0.45)
    return [from_hsv(0.11, 0.16, 0.88), dark, from_hsv(rng.random(), 0.5, 0.7)]


def _pattern(style: str, y: Float64, x: Float64) -> np.ndarray:
    """Which yarn is where, from the rug's middle: (h, w) integers 0 to 3."""
    if style == "plain":
        return np.zeros(y.shape, dtype=np.int64)
    if style == "stripes":
        return np.array([0, 1, 0, 2, 0, 3, 1, 0])[((x + 0.5) * 16).astype(np.int64) % 8]
    if style == "zigzag":
        wave = np.abs((x * 8) % 2 - 1) * 0.06
        return np.array([0, 1, 0, 2])[np.floor((y + wave) * 14).astype(np.int64) % 4]
    if style == "diamonds":
        steps = np.abs((x * 6) % 1 - 0.5) + np.abs((y * 6) % 1 - 0.5)
        return np.select([steps < 0.15, steps < 0.30, steps < 0.40], [3, 0, 1], 0)
    return _medallion(y, x)


def _medallion(y: Float64, x: Float64) -> np.ndarray:
    angle, distance = np.arctan2(y, x), np.hypot(y * 1.25, x)
    petal = distance * (1 + 0.10 * np.cos(8 * angle))
    middle = np.select([petal < 0.05, petal < 0.10, petal < 0.16, petal < 0.18], [3, 1, 2, 1], 0)
    buds = np.hypot((x * 9) % 1 - 0.5, (y * 9) % 1 - 0.5)
    return np.where((petal > 0.20) & (buds < 0.16), np.where(buds < 0.08, 3, 1), middle)


def _pile(rng: np.random.Generator, shape: tuple[int, int]) -> Float64:
    knots = fractal_noise(rng, shape, (96, 96), octaves=2)
    wear = fractal_noise(rng, shape, (3, 4), octaves=4)
    return 1 + 0.22 * (knots - 0.5) + 0.18 * (wear - 0.5)
