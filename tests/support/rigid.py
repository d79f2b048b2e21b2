"""Rigid motions drawn by chance."""

import numpy as np

from sceneq_core.ingest.transforms import nearest_rigid, rotation_of


def rigid(seed, reach_m=1.0):
    """Return T (4, 4) with any rotation and up to ``reach_m`` along each axis."""
    rng = np.random.default_rng(seed)
    motion = np.eye(4)
    motion[:3, :3] = rotation_of(rng.normal(size=3) * rng.uniform(0.2, 2.0))
    motion[:3, 3] = rng.uniform(-reach_m, reach_m, 3)
    return nearest_rigid(motion)
