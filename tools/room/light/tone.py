"""From light to the eight bits of a picture."""

import numpy as np

from sceneq_core.arrays import Float32, Float64, UInt8

MIDDLE = 0.20  # the logarithmic mean of what is seen becomes this bright, as in a good exposure
_STEPS = 8192


def _film(light: Float64) -> Float64:
    """Filmic curve after Narkowicz' fit of ACES: a soft toe, and no hard end for highlights."""
    x = 0.8 * light
    curve = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
    encoded: Float64 = np.clip(curve, 0, 1) ** (1 / 2.2)
    return encoded


def _table() -> UInt8:
    share = np.arange(_STEPS) / _STEPS
    steps: UInt8 = np.round(_film(share**2 / (1 - share**2)) * 255).astype(np.uint8)
    return steps


_TABLE = _table()


def tone_mapped(radiance: Float32, exposure: float) -> UInt8:
    """Return sRGB uint8 of linear radiance times exposure, same shape."""
    light = np.maximum(radiance, 0) * np.float32(exposure)
    share = np.sqrt(light / (1 + light))
    mapped: UInt8 = _TABLE[(share * (_STEPS - 1) + np.float32(0.5)).astype(np.int32)]
    return mapped


def auto_exposure(radiance: Float32) -> float:
    """Return the factor that makes the logarithmic mean of (N, 3) radiances mid-grey."""
    luminance = radiance @ np.array([0.2126, 0.7152, 0.0722])
    seen = luminance[luminance > 0]
    if not len(seen):
        return 1.0
    floor = 0.02 * float(np.median(seen))  # black holes must not brighten all the rest
    return MIDDLE / float(np.exp(np.log(np.maximum(luminance, floor)).mean()))
