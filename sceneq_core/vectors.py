"""Directions."""

import numpy as np

from sceneq_core.arrays import Float64


def unit_rows(vectors: Float64) -> Float64:
    """Return ``vectors`` (N, 3) with length 1, float64; rows of length 0 stay 0."""
    x, y, z = vectors.T
    length = np.sqrt(x * x + y * y + z * z)
    length[length == 0] = 1.0
    unit: Float64 = vectors / length[:, None]
    return unit
