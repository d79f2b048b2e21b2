"""Smooth edges: rays through the corners that pixels of different surfaces share."""

import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64, Int32

CONTRAST = 0.3  # step of log(1 + 8 x brightness); weaker ones are texture, smooth in itself
STEPS = 4.0  # times the slope of a surface: a larger change of depth is an edge
CORNER_SHARE = 0.125  # of a pixel belongs to each of its corners, the rest to its centre


def edge_corners(radiance: Float32, surface: Int32, depth_m: Float32, slope_m: Float32) -> Bool:
    """Return bool (H-1, W-1): corners beside a change of surface, or a step in depth or brightness.

    Corner (y, x) is the one that pixels (y, x) and (y + 1, x + 1) share.

    Args:
        radiance: float32 (H, W, 3), scaled so that mid-grey is about 0.2.
        surface: int32 (H, W), equal numbers are one surface.
        depth_m: float32 (H, W); ``slope_m``: the change to the next pixel that its slope explains.
    """
    grey = radiance @ np.full(3, 8 / 3, np.float32)
    brightness = np.log1p(grey)
    across, down = (_steps(axis, brightness, surface, depth_m, slope_m) for axis in (1, 0))
    corners: Bool = across[1:] | across[:-1] | down[:, 1:] | down[:, :-1]
    return corners


def _steps(
    axis: int, brightness: Float32, surface: Int32, depth_m: Float32, slope_m: Float32
) -> Bool:
    """Return where a pixel differs from the next one along an axis."""
    before = tuple(slice(None, -1) if a == axis else slice(None) for a in range(2))
    after = tuple(slice(1, None) if a == axis else slice(None) for a in range(2))
    step: Bool = np.abs(brightness[after] - brightness[before]) > CONTRAST
    step |= surface[after] != surface[before]
    allowed = np.maximum(slope_m[before], slope_m[after]) * np.float32(STEPS)
    step |= np.abs(depth_m[after] - depth_m[before]) > allowed
    return step


def around_corners(corners: Bool, count: int) -> Float64:
    """Return the pixel positions x, y (count, C, 2) of rays through C marked corners.

    Several rays lie on a circle that stays clear of the pixels' centres.
    """
    y, x = np.nonzero(corners)
    angle = 2 * np.pi * (np.arange(count) / max(count, 1)) + 0.3
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1) * (0.25 if count > 1 else 0)
    positions: Float64 = np.column_stack([x, y]) + 0.5 + circle[:, None]
    return positions


def blended(radiance: Float32, corners: Bool, at_corners: Float32) -> Float32:
    """Return the picture (H, W, 3) with the light (C, 3) at marked corners mixed into pixels."""
    y, x = np.nonzero(corners)
    width = radiance.shape[1]
    before = radiance.reshape(-1, 3)
    smooth = before.copy()
    for below in (0, 1):
        for right in (0, 1):
            pixel = (y + below) * width + x + right
            change = at_corners - before.take(pixel, axis=0)
            smooth[pixel] += change * np.float32(CORNER_SHARE)
    return smooth.reshape(radiance.shape)
