"""What colour things have and what colour words say, in the eleven basic terms of English.

The terms are those of B. Berlin and P. Kay, "Basic Color Terms" (1969). A pixel belongs to each
term by the CIELAB distance to the term's nearest prototype.
"""

import re
from functools import cache

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Int64, UInt8

PROTOTYPES_RGB = {
    "black": ((15, 15, 15), (40, 40, 42)),
    "grey": ((75, 75, 75), (128, 128, 128), (170, 170, 170)),
    "white": ((250, 250, 250), (222, 222, 222)),
    "red": ((205, 25, 35), (130, 15, 25)),
    "orange": ((245, 130, 30), (230, 85, 25)),
    "brown": ((85, 50, 25), (140, 90, 50), (185, 145, 100)),
    "yellow": ((250, 220, 45), (225, 205, 110)),
    "green": ((40, 140, 60), (120, 185, 80), (25, 75, 40)),
    "blue": ((30, 85, 190), (110, 170, 225), (20, 30, 85), (30, 150, 180)),
    "purple": ((110, 50, 140), (150, 110, 185)),
    "pink": ((240, 130, 170), (245, 175, 190), (230, 60, 140)),
}
"""Term -> sRGB examples of it; several where a term spans light and dark or two hues."""

COLOUR_TERMS = tuple(PROTOTYPES_RGB)

SAME_AS = {
    "gray": "grey",
    "silver": "grey",
    "ivory": "white",
    "crimson": "red",
    "maroon": "red",
    "scarlet": "red",
    "wooden": "brown",
    "beige": "brown",
    "golden": "yellow",
    "turquoise": "blue",
    "navy": "blue",
    "violet": "purple",
    "magenta": "pink",
}
SHADES = frozenset({"dark", "light", "bright", "pale", "deep"})

SPREAD = 10.0
"""CIELAB units within which a pixel counts for two terms alike."""
LIGHTNESS_WEIGHT = 0.7
"""Below 1, because shading changes the lightness of a surface more than its hue."""
LEVELS = 32
MAX_PIXELS = 4096


def colour_shares(rgb: UInt8, mask: Bool) -> Float32:
    """Return how much of the masked pixels has each term's colour: float32 (11,), sum 1.

    ``rgb`` uint8 (h, w, 3) and ``mask`` bool (h, w); an empty mask counts as a full one.
    """
    pixels = rgb[mask] if mask.any() else rgb.reshape(-1, 3)
    pixels = pixels[:: -(-len(pixels) // MAX_PIXELS)]
    shares: Float32 = _term_table()[_cell(pixels)].mean(axis=0, dtype=np.float32)
    return shares


def split_colours(text: str) -> tuple[str, Float32]:
    """Return ``text`` without its colour words, and the share (11,) each term has among them.

    A shade ("dark blue") goes with its colour. The shares are zero when no colour is named.
    """
    words = re.findall(r"[^\s,;]+", text.lower())
    rest: list[str] = []
    shares = np.zeros(len(COLOUR_TERMS), np.float32)
    for word in words:
        term = SAME_AS.get(word, word)
        if term in PROTOTYPES_RGB:
            shares[COLOUR_TERMS.index(term)] += 1
            rest = rest[:-1] if rest and rest[-1] in SHADES else rest
        else:
            rest.append(word)
    return " ".join(rest), shares / max(1.0, float(shares.sum()))


def _cell(pixels: UInt8) -> Int64:
    r, g, b = np.moveaxis(pixels.astype(np.int64) * LEVELS // 256, -1, 0)
    return np.asarray((r * LEVELS + g) * LEVELS + b, np.int64)


@cache
def _term_table() -> Float32:
    """Return the shares of every cell of a coarse RGB cube, (32768, 11)."""
    level = (np.arange(LEVELS) + 0.5) * (256 / LEVELS)
    cells = np.stack(np.meshgrid(level, level, level, indexing="ij"), axis=-1).reshape(-1, 3)
    lab = _lab(cells)
    nearest = np.stack(
        [_squared_distance(lab, _lab(np.array(p))).min(axis=1) for p in PROTOTYPES_RGB.values()],
        axis=1,
    )
    shares = np.exp((nearest.min(axis=1, keepdims=True) - nearest) / (2 * SPREAD**2))
    return np.asarray(shares / shares.sum(axis=1, keepdims=True), np.float32)


def _lab(rgb: Float32) -> Float32:
    """Return CIELAB (N, 3) of sRGB values 0..255 (N, 3), lightness weighted."""
    unit = (rgb / 255.0).astype(np.float32).reshape(-1, 1, 3)
    lab = cv2.cvtColor(unit, cv2.COLOR_RGB2LAB).reshape(-1, 3)
    return np.asarray(lab * (LIGHTNESS_WEIGHT, 1.0, 1.0), np.float32)


def _squared_distance(a: Float32, b: Float32) -> Float32:
    return np.asarray(((a[:, None] - b[None]) ** 2).sum(axis=2), np.float32)
