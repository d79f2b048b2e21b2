"""Directions."""

import numpy as np

from sceneq_core.arrays import Float64


def unit_rows(vectors: Float64) -> Float64:
    """Return ``vectors`` (N, 3) with length 1, float64; rows of length 0 stay 0."""
    length = np.sqrt((vectors**2).sum(axis=1, keepdims=True))
    unit: Float64 = np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)
    return unit
