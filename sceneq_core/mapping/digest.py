"""One number for a whole map, so that two runs can be compared."""

import hashlib

import numpy as np

from sceneq_core.arrays import Float32, Int32


def map_digest(voxel_coord: Int32, points_world: Float32, instance_id: Int32) -> str:
    """Return the sha256 hex digest of the voxels in the order of their coordinates.

    ``voxel_coord`` int32 (N, 3), ``points_world`` float32 (N, 3) metres, ``instance_id`` int32
    (N,). Row order does not matter; one changed bit does.
    """
    order = np.lexsort(voxel_coord.T[::-1])
    digest = hashlib.sha256()
    digest.update(np.ascontiguousarray(voxel_coord[order], dtype="<i4").tobytes())
    digest.update(np.ascontiguousarray(points_world[order], dtype="<f4").tobytes())
    digest.update(np.ascontiguousarray(instance_id[order], dtype="<i4").tobytes())
    return digest.hexdigest()
