"""What the readers of the map know about its voxels."""

import numpy as np

from sceneq_core.arrays import Bool, Float32, Int32, UInt8
from sceneq_core.mapping.rows import with_rows
from sceneq_core.mapping.superpoints import Superpoints
from sceneq_core.mapping.voxels import Voxels


class Published:
    """The last published position, colour and superpoint of every voxel.

    A voxel is published again when its superpoint changed, its mean moved by ``step_m`` or a
    colour channel changed by ``_COLOUR_STEP``: running means never stand still, and readers need
    not hear of it.
    """

    _COLOUR_STEP = 6

    def __init__(self, step_m: float) -> None:
        self._step_m = step_m
        self.count = 0
        self.points_world = np.zeros((0, 3), np.float32)
        self.rgb = np.zeros((0, 3), np.uint8)
        self.superpoint_id = np.zeros(0, np.int32)
        self._known = np.zeros(0, np.bool_)

    def all_ids(self) -> Int32:
        """Return the ids of all published voxels, sorted."""
        return np.flatnonzero(self._known).astype(np.int32)

    def retract(self, voxel_id: Int32) -> Int32:
        """Forget voxels that are gone; return those that readers know."""
        known = voxel_id[self._known[voxel_id]]
        self._known[known] = False
        self.count -= len(known)
        return known

    def renew(self, voxels: Voxels, superpoints: Superpoints, voxel_id: Int32) -> Int32:
        """Take over what changed among ``voxel_id``; return the ids to publish, sorted."""
        self._reserve(len(voxels))
        points = voxels.points_world(voxel_id).astype(np.float32)
        rgb, superpoint = voxels.rgb(voxel_id), superpoints.of(voxel_id)
        news = self._differs(voxel_id, points, rgb, superpoint)
        changed = voxel_id[news]
        self.count += int((~self._known[changed]).sum())
        self.points_world[changed], self.rgb[changed] = points[news], rgb[news]
        self.superpoint_id[changed], self._known[changed] = superpoint[news], True
        return np.sort(changed)

    def _differs(self, voxel_id: Int32, points: Float32, rgb: UInt8, superpoint: Int32) -> Bool:
        moved = np.abs(points - self.points_world[voxel_id]).max(axis=1, initial=0.0)
        tint = np.abs(rgb.astype(np.int16) - self.rgb[voxel_id]).max(axis=1, initial=0)
        differs = ~self._known[voxel_id] | (superpoint != self.superpoint_id[voxel_id])
        differs |= (moved > self._step_m) | (tint >= self._COLOUR_STEP)
        return np.asarray(differs)

    def _reserve(self, count: int) -> None:
        self.points_world = with_rows(self.points_world, count, 0.0)
        self.rgb = with_rows(self.rgb, count, 0)
        self.superpoint_id = with_rows(self.superpoint_id, count, -1)
        self._known = with_rows(self._known, count, False)
