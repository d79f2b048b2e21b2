"""Anti-aliased text in pictures."""

from functools import cache
from threading import Lock
from typing import Any

import cv2
import numpy as np

from sceneq_core.arrays import UInt8

Colour = tuple[int, int, int]
INK: Colour = (38, 40, 44)
FAINT: Colour = (120, 124, 130)
PAPER: Colour = (255, 255, 255)
REGULAR, BOLD = 400, 600
_LETTERING = Lock()
"""The one font face changes with its weight; views are drawn side by side."""


def text_size(text: str, pixels: int, weight: int = REGULAR) -> tuple[int, int]:
    """Return width and height in pixels; the height is that of a line, whatever its letters."""
    with _LETTERING:
        left, _, width, _ = cv2.getTextSize((1, 1), text, (0, 0), _face(), pixels, weight)
    return left + width, pixels


def write(
    image: UInt8,
    text: str,
    at: tuple[int, int],
    pixels: int,
    colour: Colour = INK,
    weight: int = REGULAR,
    halo: bool = False,
) -> None:
    """Write on ``image``; ``at`` is the upper left corner of the line, ``halo`` a white rim."""
    baseline = (at[0], at[1] + round(0.82 * pixels))
    if halo:
        _write_halo(image, text, baseline, pixels, weight)
    _put(image, text, baseline, colour, pixels, weight)


def _put(
    image: UInt8,
    text: str,
    baseline: tuple[int, int],
    colour: Colour | int,
    pixels: int,
    weight: int,
) -> None:
    with _LETTERING:
        cv2.putText(image, text, baseline, colour, _face(), pixels, weight)


def _write_halo(
    image: UInt8, text: str, baseline: tuple[int, int], pixels: int, weight: int
) -> None:
    ink = np.zeros(image.shape[:2], np.uint8)
    _put(ink, text, baseline, 255, pixels, weight)
    rim = cv2.blur(cv2.dilate(ink, np.ones((3, 3), np.uint8)), (3, 3))[..., None] / 255.0
    image[:] = (image * (1 - 0.85 * rim) + 0.85 * rim * np.array(PAPER)).astype(np.uint8)


@cache
def _face() -> Any:
    """Return the TrueType font that OpenCV brings along."""
    return cv2.FontFace("sans")
