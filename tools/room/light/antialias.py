"""Which pixels lie on an edge, and where in a pixel further rays go."""

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64, Int32

CONTRAST = 0.3  # step of log(1 + 8 x brightness); weaker ones are texture, smooth in itself
STEPS = 4.0  # times the slope of a surface: a larger change of depth is an edge


def edge_pixels(radiance: Float32, surface: Int32, depth_m: Float32, slope_m: Float32) -> Bool:
    """Return bool (H, W): pixels beside another surface, or a step in depth or brightness.

    Args:
        radiance: float32 (H, W, 3), scaled so that mid-grey is about 0.2.
        surface: int32 (H, W), equal numbers are one surface.
        depth_m: float32 (H, W); ``slope_m``: the change to the next pixel that its slope explains.
    """
    brightness = cv2.log(1 + 8 * (radiance @ np.full(3, 1 / 3, np.float32)))
    edge = np.zeros(surface.shape, bool)
    for axis in range(2):
        before = tuple(slice(None, -1) if a == axis else slice(None) for a in range(2))
        after = tuple(slice(1, None) if a == axis else slice(None) for a in range(2))
        step = np.abs(brightness[after] - brightness[before]) > CONTRAST
        step |= surface[after] != surface[before]
        allowed = np.maximum(slope_m[before], slope_m[after]) * np.float32(STEPS)
        step |= np.abs(depth_m[after] - depth_m[before]) > allowed
        edge[before] |= step
        edge[after] |= step
    return edge


def sub_pixels(count: int) -> Float64:
    """Return (count, 2) offsets in pixels, on a circle: with the centre they cover the pixel."""
    angle = 2 * np.pi * (np.arange(count) / max(count, 1)) + 0.3
    return 0.36 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
