"""Vectors of many rays, held as three rows."""

import numpy as np

from sceneq_core.arrays import Float32

SHORTEST = 1e-9


def dot(a: Float32, b: Float32) -> Float32:
    """Return the products (N,) of vectors that are the columns of (3, N)."""
    product: Float32 = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


def length(vectors: Float32) -> Float32:
    """Return the lengths (N,) of the columns of (3, N); none is zero, so that they may divide."""
    long: Float32 = np.maximum(np.sqrt(dot(vectors, vectors)), np.float32(SHORTEST))
    return long
