"""Evaluation points on the surface that a recording shows, by a vote of its pixels."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64, Int64
from sceneq_core.checks import need_at_least, need_positive
from sceneq_core.depth import pixel_rays

COORD_BITS = 20
COORD_LIMIT = 1 << (COORD_BITS - 1)
"""Voxels from the origin that a packed coordinate can hold: 20 km at 4 cm."""


@dataclass(frozen=True, slots=True)
class SurfaceVotesParams:
    """``voxel_m``: spacing of the points; ``max_depth_m``: farther pixels have no vote.

    ``min_votes``: a voxel with fewer is noise. ``stride``: of ``stride`` x ``stride`` pixels one
    votes. A Kinect is off by 2.6 cm (one sigma) at 4 m, which is most of a voxel of 4 cm.
    """

    voxel_m: float = 0.04
    max_depth_m: float = 4.0
    min_votes: int = 3
    stride: int = 2

    def __post_init__(self) -> None:
        need_positive(self, "voxel_m", "max_depth_m")
        need_at_least(self, 1, "min_votes", "stride")


class SurfaceVotes:
    """Collects votes (voxel, number of the thing) with the points that gave them."""

    def __init__(self, params: SurfaceVotesParams | None = None) -> None:
        self.params = params or SurfaceVotesParams()
        self._tables = [_VoteTable.empty()]

    def add(
        self, depth_m: Float32, number: Int64, may_vote: Bool, K: Float64, T_world_camera: Float64
    ) -> None:
        """Let the pixels of one image vote.

        Args:
            depth_m: float32 (H, W) metres, 0 = no measurement.
            number: int64 (H, W) what each pixel shows, 0 or more.
            may_vote: bool (H, W); pixels of things that are elsewhere by now may not.
            K: float64 (3, 3) of both images, pixels.
            T_world_camera: float64 (4, 4), metres.

        Raises:
            ValueError: a point beyond what voxel coordinates can hold.
        """
        kept = np.s_[:: self.params.stride, :: self.params.stride]
        z = depth_m[kept].astype(np.float64)
        valid = (z > 0) & (z <= self.params.max_depth_m) & may_vote[kept]
        x, y = pixel_rays(K, depth_m.shape, self.params.stride)
        rays = np.stack(np.broadcast_arrays(x[None], y[:, None], 1.0), axis=-1)
        points_camera = rays[valid] * z[valid][:, None]
        points_world = points_camera @ T_world_camera[:3, :3].T + T_world_camera[:3, 3]
        voxel = _packed(np.floor(points_world / self.params.voxel_m))
        votes = np.ones(len(voxel), np.int64)
        self._tables.append(_VoteTable(voxel, number[kept][valid], votes, points_world).merged())

    def points(self) -> tuple[Float32, Int64]:
        """Return float32 (N, 3) metres and the number int64 (N,) of every voxel.

        A voxel belongs to the thing with most votes, the lowest number among equals; its point is
        the mean of the points that voted so.
        """
        table = _VoteTable.stacked(self._tables).merged()
        self._tables = [table]
        order = np.lexsort((table.number, -table.votes, table.voxel))
        voxel, first = np.unique(table.voxel[order], return_index=True)
        total = np.bincount(np.searchsorted(voxel, table.voxel), table.votes, len(voxel))
        row = order[first][total >= self.params.min_votes]
        mean = table.sum_world[row] / table.votes[row][:, None]
        return mean.astype(np.float32), table.number[row]


@dataclass(frozen=True, slots=True, eq=False)
class _VoteTable:
    """Parallel rows: packed voxel (R,), number (R,), votes (R,), sum of the points (R, 3)."""

    voxel: Int64
    number: Int64
    votes: Int64
    sum_world: Float64

    @staticmethod
    def empty() -> "_VoteTable":
        none = np.zeros(0, np.int64)
        return _VoteTable(none, none, none, np.zeros((0, 3)))

    @staticmethod
    def stacked(tables: list["_VoteTable"]) -> "_VoteTable":
        return _VoteTable(
            *(
                np.concatenate([t.voxel for t in tables]),
                np.concatenate([t.number for t in tables]),
            ),
            *(
                np.concatenate([t.votes for t in tables]),
                np.concatenate([t.sum_world for t in tables]),
            ),
        )

    def merged(self) -> "_VoteTable":
        """Return one row per (voxel, number)."""
        if not len(self.voxel):
            return self
        order = np.lexsort((self.number, self.voxel))
        voxel, number = self.voxel[order], self.number[order]
        starts = np.append(True, (np.diff(voxel) != 0) | (np.diff(number) != 0))
        first = np.flatnonzero(starts)
        return _VoteTable(
            voxel[first],
            number[first],
            np.add.reduceat(self.votes[order], first),
            np.add.reduceat(self.sum_world[order], first),
        )


def _packed(coord: Float64) -> Int64:
    if len(coord) and np.abs(coord).max() >= COORD_LIMIT:
        raise ValueError(f"a point lies {np.abs(coord).max():.0f} voxels from the origin")
    whole = coord.astype(np.int64) + COORD_LIMIT
    packed: Int64 = (whole[:, 0] << 2 * COORD_BITS) | (whole[:, 1] << COORD_BITS) | whole[:, 2]
    return packed
