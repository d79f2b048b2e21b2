"""Colours of a picture of instances."""

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Int32, UInt8
from sceneq_core.picture.lettering import Colour

GOLDEN_RATIO = 0.618033988749895
LIGHTNESS = (72.0, 60.0, 80.0, 66.0)
CHROMA = (52.0, 40.0, 60.0)
NO_INSTANCE = 200
SHELL_CHROMA = 0.25
SHELL_DARKEST, SHELL_RANGE = 185.0, 60.0
DIM_TO = 236
DIM = 0.8
MARK_COLOURS: tuple[Colour, ...] = (
    (222, 54, 34), (20, 104, 196), (0, 132, 80), (146, 60, 176), (196, 110, 0), (0, 122, 140),
)  # fmt: skip


def instance_colours(instance_id: Int32, rgb: UInt8) -> UInt8:
    """Return a distinct colour per instance (N, 3); points of no instance are faint grey.

    Some of the brightness comes from the real colour (N, 3), so that shapes stay readable.
    """
    flat = _flat_colours(instance_id)
    flat[instance_id == 0] = NO_INSTANCE
    return _lit(flat, rgb)


def quieted(colours: UInt8, is_shell: Bool) -> UInt8:
    """Return colours (N, 3) in which walls and floors are pale: they surround what matters."""
    out = colours.astype(np.float32)
    shell = out[is_shell]
    grey = shell.mean(axis=1, keepdims=True)
    out[is_shell] = SHELL_DARKEST + SHELL_RANGE * grey / 255 + SHELL_CHROMA * (shell - grey)
    quiet: UInt8 = np.clip(out, 0, 255).astype(np.uint8)
    return quiet


def dimmed(colours: UInt8) -> UInt8:
    """Return colours (N, 3) faint enough for something else to stand out."""
    out = colours.astype(np.float32)
    grey = out.mean(axis=1, keepdims=True)
    faint: UInt8 = (out * (1 - DIM) + DIM * (0.35 * grey + 0.65 * DIM_TO)).astype(np.uint8)
    return faint


def tinted(rgb: UInt8, colour: tuple[int, int, int]) -> UInt8:
    """Return one ``colour`` for all, with the brightness of ``rgb`` (N, 3)."""
    return _lit(np.broadcast_to(np.array(colour, np.float32), rgb.shape), rgb)


def mark_colours(count: int) -> list[Colour]:
    """Return a strong colour for each of ``count`` marks."""
    return [MARK_COLOURS[number % len(MARK_COLOURS)] for number in range(count)]


def _flat_colours(instance_id: Int32) -> Float32:
    """Return hues that lie far apart for ids that lie close together, equally light to the eye."""
    if not len(instance_id):
        return np.zeros((0, 3), np.float32)  # OpenCV converts no empty image
    ids, where = np.unique(instance_id, return_inverse=True)
    hue = 2 * np.pi * (ids * GOLDEN_RATIO % 1.0)
    chroma = np.take(CHROMA, ids % len(CHROMA))
    lightness = np.take(LIGHTNESS, ids % len(LIGHTNESS))
    lab = np.stack([lightness, chroma * np.cos(hue), chroma * np.sin(hue)], axis=1)
    shown = cv2.cvtColor(lab.astype(np.float32)[None], cv2.COLOR_Lab2RGB)[0]
    flat: Float32 = (255 * np.clip(shown, 0, 1))[where]
    return flat


def _lit(flat: Float32, rgb: UInt8) -> UInt8:
    grey = rgb.mean(axis=1, keepdims=True)
    colours: UInt8 = (flat * (0.62 + 0.38 * grey / 255)).astype(np.uint8)
    return colours
