"""Rotations as unit quaternions, x y z w: what poses on the wire are made of."""

import numpy as np

from sceneq_core.arrays import Float64

TOLERANCE = 0.01
"""A quaternion of a length farther from 1 was never normalised: somebody forgot to fill it in."""
_STRAIGHT = 0.9995
"""Cosine of half an angle below which the arc and its chord are the same."""


def unit_quaternion(xyzw: Float64) -> Float64:
    """Return ``xyzw`` (4,) with length 1; raise ``ValueError`` when it is far from it."""
    length = float(np.linalg.norm(np.clip(xyzw, -2.0, 2.0)))
    if not abs(length - 1.0) <= TOLERANCE:
        raise ValueError(f"quaternion {np.round(xyzw, 4).tolist()} has length {length:.3g}, not 1")
    return np.asarray(xyzw / length, np.float64)


def rigid_from_quaternion(xyz_m: Float64, xyzw: Float64) -> Float64:
    """Return the rigid motion (4, 4) of a translation, metres, and a unit quaternion."""
    x, y, z, w = xyzw
    T_a_b = np.eye(4)
    T_a_b[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    T_a_b[:3, 3] = xyz_m
    return T_a_b


def slerp(a: Float64, b: Float64, share: float) -> Float64:
    """Return the rotation a ``share`` of the shorter way from ``a`` to ``b``, unit quaternions.

    Shoemake 1985, DOI 10.1145/325165.325242.
    """
    cosine = float(a @ b)
    b, cosine = (-b, -cosine) if cosine < 0 else (b, cosine)
    if cosine > _STRAIGHT:
        between = a + share * (b - a)
    else:
        angle = np.arccos(cosine)
        between = np.sin((1 - share) * angle) * a + np.sin(share * angle) * b
    return np.asarray(between / np.linalg.norm(between), np.float64)


def quaternion_of(R_a_b: Float64) -> Float64:
    """Return the unit quaternion (4,) x y z w, w >= 0, of a rotation (3, 3)."""
    # Of the four ways to take the root, the one with the largest argument loses no digits.
    squares = 1.0 + np.array(
        [
            R_a_b[0, 0] - R_a_b[1, 1] - R_a_b[2, 2],
            R_a_b[1, 1] - R_a_b[0, 0] - R_a_b[2, 2],
            R_a_b[2, 2] - R_a_b[0, 0] - R_a_b[1, 1],
            R_a_b[0, 0] + R_a_b[1, 1] + R_a_b[2, 2],
        ]
    )
    sums = np.array(
        [
            [
                squares[0],
                R_a_b[0, 1] + R_a_b[1, 0],
                R_a_b[0, 2] + R_a_b[2, 0],
                R_a_b[2, 1] - R_a_b[1, 2],
            ],
            [
                R_a_b[0, 1] + R_a_b[1, 0],
                squares[1],
                R_a_b[1, 2] + R_a_b[2, 1],
                R_a_b[0, 2] - R_a_b[2, 0],
            ],
            [
                R_a_b[0, 2] + R_a_b[2, 0],
                R_a_b[1, 2] + R_a_b[2, 1],
                squares[2],
                R_a_b[1, 0] - R_a_b[0, 1],
            ],
            [
                R_a_b[2, 1] - R_a_b[1, 2],
                R_a_b[0, 2] - R_a_b[2, 0],
                R_a_b[1, 0] - R_a_b[0, 1],
                squares[3],
            ],
        ]
    )
    row = sums[int(np.argmax(squares))]
    xyzw: Float64 = row / np.linalg.norm(row)
    return -xyzw if xyzw[3] < 0 else xyzw
