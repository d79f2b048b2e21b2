"""Rigid motions as 4x4 matrices: ``p_a = T_a_b @ p_b``, metres."""

import numpy as np

from sceneq_core.arrays import Float64

TOLERANCE = 1e-3
"""How far R^T R may be from the identity: pose files round to four or more digits."""


def rigid_defect(T_a_b: Float64) -> str | None:
    """Return what keeps ``T_a_b`` (4, 4) from being a rigid motion, ``None`` when it is one."""
    if T_a_b.shape != (4, 4):
        return f"expected 4x4, got {T_a_b.shape}"
    if not np.isfinite(T_a_b).all():
        return "not finite"
    if (T_a_b[3] != (0.0, 0.0, 0.0, 1.0)).any():
        return f"last row is {T_a_b[3].tolist()}, expected 0 0 0 1"
    R_a_b = T_a_b[:3, :3]
    if np.abs(R_a_b).max() > 1.0 + TOLERANCE:
        return f"not rigid: an entry of the rotation is {np.abs(R_a_b).max():.2g}"
    off = float(np.abs(R_a_b.T @ R_a_b - np.eye(3)).max())
    if off > TOLERANCE:
        return f"not rigid: R^T R differs from the identity by {off:.2g}"
    return None if np.linalg.det(R_a_b) > 0 else "not rigid: a reflection"


def nearest_rigid(T_a_b: Float64) -> Float64:
    """Return ``T_a_b`` with its rotation made exact: the nearest orthogonal matrix."""
    left, _, right = np.linalg.svd(T_a_b[:3, :3])
    exact = T_a_b.copy()
    exact[:3, :3] = left @ right
    return exact


def inverse(T_a_b: Float64) -> Float64:
    """Return the inverse (4, 4) of a rigid motion."""
    R_a_b, t = T_a_b[:3, :3], T_a_b[:3, 3]
    result = np.eye(4)
    result[:3, :3] = R_a_b.T
    result[:3, 3] = -R_a_b.T @ t
    return result


def transform(T_a_b: Float64, points_b: Float64) -> Float64:
    """Return ``points_b`` (N, 3) in the coordinates of ``a``."""
    moved: Float64 = points_b @ T_a_b[:3, :3].T + T_a_b[:3, 3]
    return moved


def distance_m(T_a: Float64, T_b: Float64) -> float:
    """Return how far apart the origins of two poses are, metres."""
    return float(np.linalg.norm(T_a[:3, 3] - T_b[:3, 3]))


def angle_deg(T_a: Float64, T_b: Float64) -> float:
    """Return the angle of the rotation from one pose to the other, degrees in [0, 180]."""
    R_a_b = T_a[:3, :3].T @ T_b[:3, :3]
    axis = (R_a_b[2, 1] - R_a_b[1, 2], R_a_b[0, 2] - R_a_b[2, 0], R_a_b[1, 0] - R_a_b[0, 1])
    # The arc tangent stays exact near 0 degrees, where the arc cosine of the trace does not.
    return float(np.degrees(np.arctan2(np.linalg.norm(axis), np.trace(R_a_b) - 1.0)))


def rotation_of(vector: Float64) -> Float64:
    """Return the rotation (3, 3) about ``vector`` (3,) by its length, radians."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    # sin(x) / x and (1 - cos x) / x^2, which are 1 and 1/2 at 0.
    first, second = np.sinc(angle / np.pi), 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    rotation: Float64 = np.eye(3) + first * skew + second * (skew @ skew)
    return rotation
