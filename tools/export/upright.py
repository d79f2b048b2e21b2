"""Turning the world so that its up direction is an axis, as other programs want it."""

import numpy as np
from scipy.spatial.transform import Rotation

from sceneq_core.arrays import Float64

LEVEL_COS = 0.9962
"""Within 5 degrees the world's own axis is up, and its coordinates can stay as they are."""


def R_target_world(up_world: Float64, axis: Float64) -> Float64:
    """Return the least rotation (3, 3) that takes ``up_world`` (3,) to the unit ``axis`` (3,)."""
    rotation, _ = Rotation.align_vectors(axis[None], unit(up_world)[None])
    return np.asarray(rotation.as_matrix(), np.float64)


def is_level(up_world: Float64, axis: Float64) -> bool:
    """Whether ``axis`` (3,) is as good as up."""
    return bool(unit(up_world) @ axis >= LEVEL_COS)


def unit(up_world: Float64) -> Float64:
    """Return ``up_world`` (3,) of length 1; where it is not known yet, the z axis."""
    length = np.linalg.norm(up_world)
    return np.array([0.0, 0.0, 1.0]) if length == 0 else np.asarray(up_world / length, np.float64)
