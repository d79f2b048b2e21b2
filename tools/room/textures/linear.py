"""sRGB and light."""

import numpy as np

from sceneq_core.arrays import Float32

GAMMA = 2.2


def linear(srgb: Float32) -> Float32:
    """Return the linear light of sRGB values in 0..1."""
    share = np.clip(srgb, 0, 1).astype(np.float32)
    light: Float32 = np.power(share, np.float32(GAMMA), dtype=np.float32)
    return light


LINEAR_OF_BYTE: Float32 = linear(np.arange(256, dtype=np.float32) / np.float32(255))
"""The linear light of each of the 256 sRGB values."""
