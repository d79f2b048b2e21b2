"""What people call a colour."""

import numpy as np

from sceneq_core.arrays import Array, Float64, Int64

COLOURS = (
    "black", "white", "grey", "red", "orange", "brown",
    "yellow", "green", "blue", "purple", "pink", "beige", "light grey",
)  # fmt: skip

CONFUSED = {
    "black": {"black", "grey", "brown", "blue"},
    "white": {"white", "beige", "light grey"},
    "light grey": {"light grey", "grey", "white", "beige"},
    "grey": {"grey", "light grey", "black"},
    "red": {"red", "pink", "orange", "brown"},
    "orange": {"orange", "red", "yellow", "brown", "beige"},
    "brown": {"brown", "orange", "red", "beige", "black", "yellow"},
    "yellow": {"yellow", "orange", "beige", "brown", "green"},
    "green": {"green", "yellow", "blue"},
    "blue": {"blue", "purple", "green", "black"},
    "purple": {"purple", "pink", "blue", "red"},
    "pink": {"pink", "red", "purple", "beige"},
    "beige": {"beige", "white", "yellow", "brown", "orange", "pink", "light grey"},
}
"""Colour -> the names that people may give to the same thing, itself among them."""

HUES = ((14, "red"), (42, "orange"), (68, "yellow"), (165, "green"), (262, "blue"))
"""Degrees up to which a strong colour has that name; then purple, pink, and red again."""
GREYISH, BLACKISH, DIM, PALE, WHITISH = 0.18, 0.22, 0.33, 0.6, 0.74


def colour_index(srgb: Array) -> Int64:
    """Return the index into ``COLOURS`` of each colour, (N,); ``srgb`` (N, 3), 0 to 1.

    By hue, saturation and value; between names that touch, the boundaries are those of common
    colour-naming surveys and no more exact than people are, see ``CONFUSED``.
    """
    hue, saturation, value = _hsv(np.asarray(srgb, np.float64))
    names = np.select(
        [
            (value < BLACKISH) | ((value < DIM) & (saturation < 2 * GREYISH)),
            (saturation < GREYISH) & (value > WHITISH),
            (saturation < GREYISH) & (value > PALE),
            saturation < GREYISH,
            (hue >= 20) & (hue < 68) & (saturation < 0.42) & (value > 0.6),
            (hue >= 12) & (hue < 48) & (value < 0.66),
            ((hue < 14) | (hue >= 330)) & (saturation < 0.55) & (value > 0.7),
        ],
        [_at(n) for n in ("black", "white", "light grey", "grey", "beige", "brown", "pink")],
        _by_hue(hue),
    )
    return names.astype(np.int64)


def _at(name: str) -> int:
    return COLOURS.index(name)


def _by_hue(hue: Float64) -> Int64:
    bounds = [*(bound for bound, _ in HUES), 310, 340]
    names = [*(name for _, name in HUES), "purple", "pink", "red"]
    order = np.array([_at(name) for name in names])
    return order[np.searchsorted(bounds, hue, side="right")]


def _hsv(srgb: Float64) -> tuple[Float64, Float64, Float64]:
    """Return hue in degrees, saturation and value, (N,) each."""
    value, least = srgb.max(1), srgb.min(1)
    chroma = value - least
    safe = np.maximum(chroma, 1e-9)
    red, green, blue = srgb.T
    hue = np.select(
        [value == red, value == green],
        [(green - blue) / safe % 6, (blue - red) / safe + 2],
        (red - green) / safe + 4,
    )
    return hue * 60, chroma / np.maximum(value, 1e-9), value
