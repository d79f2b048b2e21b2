"""Which superpoint falls into which external proposal."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from sceneq_core.arrays import Float64, Int32, Int64
from sceneq_core.checks import need_at_least, need_between, need_positive
from sceneq_core.mapping.association import NO_GROUP, Association, GroupChange
from sceneq_core.mapping.proposals import NO_MASK, Proposals
from sceneq_core.mapping.rows import first_of_each, with_rows
from sceneq_core.mapping.superpoints import SuperpointChange, Superpoints
from sceneq_core.mapping.voxels import Voxels

Entering = Callable[[], GroupChange]


@dataclass(frozen=True, slots=True)
class ProposalParams:
    """How far external proposals reach, and how long they are trusted.

    A voxel takes the mask of the nearest point of the cloud within ``reach_m``: the spacing of the
    cloud plus the error of its registration. A superpoint takes the mask that ``min_share`` of its
    voxels fall into. A proposal counts as much as ``views`` keyframes in which it was seen.
    """

    reach_m: float = 0.05
    min_share: float = 0.5
    views: int = 3

    def __post_init__(self) -> None:
        need_positive(self, "reach_m")
        need_between(self, 0, 1, "min_share")
        need_at_least(self, 1, "views")


class Proposed:
    """Follows the superpoints as they appear; what has not been seen yet stays pending."""

    def __init__(self, params: ProposalParams) -> None:
        self._params = params
        self._tree: cKDTree | None = None
        self._of_point = np.full(0, NO_MASK, np.int32)
        self._of_voxel = np.full(0, NO_MASK, np.int32)
        self._known = np.zeros(0, np.bool_)
        self._of_superpoint = np.full(0, NO_MASK, np.int32)
        self._masks = 0

    def __bool__(self) -> bool:
        """Tell whether there are any proposals."""
        return self._tree is not None

    def take(self, proposals: Proposals) -> None:
        """Let ``proposals`` replace earlier ones, for surface that is still to come."""
        self._tree = cKDTree(proposals.points_world) if len(proposals.points_world) else None
        of_point = proposals.of_points()
        self._of_point = np.where(of_point >= 0, of_point + self._masks, NO_MASK).astype(np.int32)
        self._masks += len(proposals.score)
        self._known[:] = False

    def of(self, superpoint_id: Int32) -> Int32:
        """Return the masks of superpoints, -1 = none; numbers of later proposals go on."""
        return self._of_superpoint[superpoint_id]

    def entering(
        self,
        voxel_id: Int32,
        change: SuperpointChange,
        voxels: Voxels,
        superpoints: Superpoints,
        association: Association,
    ) -> Entering | None:
        """Return what enters the masks of the superpoints of these voxels that are new or differ.

        ``None`` without proposals.
        """
        if not self:
            return None
        points_world, superpoint_id = voxels.points_world(voxel_id), superpoints.of(voxel_id)
        voted = self.vote(voxel_id, points_world, superpoint_id, change.new_id)
        return lambda: self.enter(voted, association)

    def enter(self, superpoint_id: Int32, association: Association) -> GroupChange:
        """Let the masks of these superpoints found groups, or join those they founded before."""
        known = np.flatnonzero(self._of_superpoint >= 0).astype(np.int32)
        of_known = self.of(known)
        mask, group, _ = _most(of_known, association.of(known), max(1, len(association)))
        owner = np.full(self._masks, NO_GROUP, np.int32)
        owner[mask] = group
        mask = self.of(superpoint_id)
        return association.found(superpoint_id, mask, owner[mask], self._params.views)

    def vote(
        self, voxel_id: Int32, points_world: Float64, superpoint_id: Int32, new_id: Int32
    ) -> Int32:
        """Let all voxels of these superpoints vote; return those with another mask than before.

        ``voxel_id``, ``points_world`` and ``superpoint_id`` are parallel; ``new_id`` are the
        superpoints that came into being. Returned are superpoints with a mask, sorted.
        """
        self._look_up(voxel_id, points_world)
        count = int(max(superpoint_id.max(initial=-1), new_id.max(initial=-1))) + 1
        self._of_superpoint = with_rows(self._of_superpoint, count, NO_MASK)
        self._of_superpoint[new_id] = NO_MASK
        superpoint, mask = self._majority(superpoint_id, self._of_voxel[voxel_id])
        other = mask != self._of_superpoint[superpoint]
        self._of_superpoint[superpoint] = mask
        differing: Int32 = superpoint[other]
        return differing

    def _look_up(self, voxel_id: Int32, points_world: Float64) -> None:
        """Find the masks of voxels that were not looked up before."""
        count = int(voxel_id.max(initial=-1)) + 1
        self._of_voxel = with_rows(self._of_voxel, count, NO_MASK)
        self._known = with_rows(self._known, count, False)
        fresh = ~self._known[voxel_id]
        new_id = voxel_id[fresh]
        self._known[new_id] = True
        assert self._tree is not None
        reach_m = self._params.reach_m
        _, point = self._tree.query(points_world[fresh], distance_upper_bound=reach_m)
        self._of_voxel[new_id] = np.append(self._of_point, np.int32(NO_MASK))[point]

    def _majority(self, superpoint_id: Int32, mask: Int32) -> tuple[Int32, Int32]:
        """Return the superpoints with enough voxels in one mask, and that mask."""
        superpoint, largest, votes = _most(superpoint_id, mask, self._masks)
        enough = votes >= self._params.min_share * np.bincount(superpoint_id)[superpoint]
        return superpoint[enough], largest[enough]


def _most(key: Int32, value: Int32, values: int) -> tuple[Int32, Int32, Int64]:
    """Return the distinct keys, the most frequent ``value`` of each and how often it occurs.

    Rows with value -1 do not count.
    """
    given = value >= 0
    pair, votes = np.unique(key[given] * np.int64(values) + value[given], return_counts=True)
    largest = first_of_each(np.lexsort((-votes, pair // values)), pair // values)
    keys, most = pair[largest] // values, pair[largest] % values
    return keys.astype(np.int32), most.astype(np.int32), votes[largest]
