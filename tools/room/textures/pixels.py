"""What all painted textures share: coordinates of pixels and the step to bytes."""

import numpy as np

from sceneq_core.arrays import Float64, UInt8
from sceneq_tools.room.mesh import Colour


def coordinates(height_px: int, width_px: int) -> tuple[Float64, Float64]:
    """Return (h, w) grids of how far down and how far right a pixel's centre is, 0 to 1."""
    down = (np.arange(height_px) + 0.5) / height_px
    right = (np.arange(width_px) + 0.5) / width_px
    return np.broadcast_to(down[:, None], (height_px, width_px)), np.broadcast_to(
        right[None, :], (height_px, width_px)
    )


def opaque(image: Float64) -> UInt8:
    """Turn an sRGB image (h, w, 3), 0 to 1, into uint8 (h, w, 4) without holes."""
    levels = np.round(np.clip(image, 0.0, 1.0) * 255).astype(np.uint8)
    return np.dstack([levels, np.full(levels.shape[:2], 255, dtype=np.uint8)])


def from_hsv(hue: float, saturation: float, value: float) -> Colour:
    """Return the sRGB colour of a hue (0 to 1, wraps around), saturation and value."""
    k = (np.array([5.0, 3.0, 1.0]) + 6 * hue) % 6
    red, green, blue = value * (1 - saturation * np.clip(np.minimum(k, 4 - k), 0, 1))
    return float(red), float(green), float(blue)
