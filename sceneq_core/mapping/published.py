"""What the readers of the map know about its voxels."""

import numpy as np

from sceneq_core.arrays import Bool, Int32
from sceneq_core.mapping.rows import distinct, with_rows
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

    def renew(
        self, voxels: Voxels, superpoints: Superpoints, touched_id: Int32, partitioned_id: Int32
    ) -> Int32:
        """Take over what changed of these voxels; return the ids to publish, sorted.

        Only where the surface was touched are there other means, and only where it was partitioned
        other superpoints.
        """
        self._reserve(len(voxels))
        moved = self._take_over(voxels, touched_id)
        renamed = superpoints.of(partitioned_id) != self.superpoint_id.take(partitioned_id)
        changed = np.concatenate((moved, partitioned_id.compress(renamed)))
        voxel_id = distinct(changed, len(voxels))
        self.superpoint_id[voxel_id] = superpoints.of(voxel_id)
        return voxel_id

    def _take_over(self, voxels: Voxels, voxel_id: Int32) -> Int32:
        """Take over means that differ; return the voxels that have them."""
        points, rgb = voxels.means(voxel_id)
        step_m = np.abs(points - self.points_world.take(voxel_id, axis=0)) > self._step_m
        tint = np.abs(rgb.astype(np.int16) - self.rgb.take(voxel_id, axis=0)) >= self._COLOUR_STEP
        known = self._known.take(voxel_id)
        row = np.flatnonzero(_any_column(step_m | tint) | ~known)
        changed = voxel_id.take(row)
        self.count += len(known) - int(np.count_nonzero(known))
        self.points_world[changed], self.rgb[changed] = points.take(row, 0), rgb.take(row, 0)
        self._known[changed] = True
        return changed

    def _reserve(self, count: int) -> None:
        self.points_world = with_rows(self.points_world, count, 0.0)
        self.rgb = with_rows(self.rgb, count, 0)
        self.superpoint_id = with_rows(self.superpoint_id, count, -1)
        self._known = with_rows(self._known, count, False)


def _any_column(table: Bool) -> Bool:
    """Return the rows of (N, 3) with a true entry; for so few columns quicker than ``any``."""
    any_of: Bool = table[:, 0] | table[:, 1] | table[:, 2]
    return any_of
