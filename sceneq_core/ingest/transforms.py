"""Rigid motions as 4x4 matrices: ``p_a = T_a_b @ p_b``, metres."""

import numpy as np

from sceneq_core.arrays import Float64

TOLERANCE = 1e-3
"""How far R^T R may be from the identity: pose files round to four or more digits."""


def rigid_defect(T: Float64) -> str | None:
    """Return what keeps ``T`` (4, 4) from being a rigid motion, ``None`` when it is one."""
    if T.shape != (4, 4):
        return f"expected 4x4, got {T.shape}"
    if not np.isfinite(T).all():
        return "not finite"
    if (T[3] != (0.0, 0.0, 0.0, 1.0)).any():
        return f"last row is {T[3].tolist()}, expected 0 0 0 1"
    R = T[:3, :3]
    off = float(np.abs(R.T @ R - np.eye(3)).max())
    if off > TOLERANCE:
        return f"not rigid: R^T R differs from the identity by {off:.2g}"
    return None if np.linalg.det(R) > 0 else "not rigid: a reflection"


def inverse(T: Float64) -> Float64:
    """Return the inverse (4, 4) of a rigid motion."""
    R, t = T[:3, :3], T[:3, 3]
    result = np.eye(4)
    result[:3, :3] = R.T
    result[:3, 3] = -R.T @ t
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
    R = T_a[:3, :3].T @ T_b[:3, :3]
    axis = (R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1])
    # The arc tangent stays exact near 0 degrees, where the arc cosine of the trace does not.
    return float(np.degrees(np.arctan2(np.linalg.norm(axis), np.trace(R) - 1.0)))
