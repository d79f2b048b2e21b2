"""An instance as the boxes of its patches, in a frame whose third axis is up."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int32, Int64
from sceneq_core.mapping.patches import Patches

LEVEL, UP = slice(0, 2), 2
_TRIMMED = 0.02
_TOP_NORMAL = 0.7


@dataclass(frozen=True, slots=True)
class Shape:
    """Patches of one instance in the level frame, metres; parallel rows (N, ...).

    ``low`` and ``high`` (N, 3) are the corners of their boxes, ``voxels`` (N,) their sizes,
    ``is_top`` (N,) tells which can carry something. ``box`` (2, 3) bounds all of them but, at the
    bottom and at the top, the outermost fiftieth of the voxels: a few of a neighbour's voxels must
    not lift a thing off its table.
    """

    low: Float64
    high: Float64
    voxels: Float64
    is_top: Bool
    box: Float64

    @property
    def bottom_m(self) -> float:
        """How high it begins."""
        return float(self.box[0, UP])

    @property
    def top_m(self) -> float:
        """How high it ends."""
        return float(self.box[1, UP])

    @property
    def middle(self) -> Float64:
        """The middle of its box, (3,)."""
        middle: Float64 = self.box.mean(axis=0)
        return middle


NO_SHAPE = Shape(
    low=np.zeros((0, 3)),
    high=np.zeros((0, 3)),
    voxels=np.zeros(0),
    is_top=np.zeros(0, np.bool_),
    box=np.full((2, 3), np.nan),
)
"""What has not been measured yet; it is close to nothing."""


@dataclass(frozen=True, slots=True)
class Crowd:
    """The patches of several instances; ``of`` (M,) is the row of their owner in ``ids`` (K,)."""

    ids: Int64
    boxes: Float64
    low: Float64
    high: Float64
    is_top: Bool
    of: Int64


def shape_of(patches: Patches, superpoint_id: Int32, R_level_world: Float64) -> Shape:
    """Return the shape of an instance that consists of these superpoints, at least one."""
    low_world = patches.low_world.take(superpoint_id, axis=0)
    high_world = patches.high_world.take(superpoint_id, axis=0)
    middle = (low_world + high_world) / 2.0 @ R_level_world.T
    half = (high_world - low_world) / 2.0 @ np.abs(R_level_world).T
    voxels = patches.voxels.take(superpoint_id)
    low, high = middle - half, middle + half
    box = np.stack((low.min(axis=0), high.max(axis=0)))
    box[0, UP] = _trimmed(low[:, UP], voxels)
    box[1, UP] = -_trimmed(-high[:, UP], voxels)
    normal = patches.normal_world.take(superpoint_id, axis=0)
    return Shape(low, high, voxels, normal @ R_level_world[UP] > _TOP_NORMAL, box)


def crowd_of(shapes: Mapping[int, Shape]) -> Crowd:
    """Return several instances as one table."""
    every = list(shapes.values())
    return Crowd(
        ids=np.fromiter(shapes, np.int64, len(every)),
        boxes=np.array([one.box for one in every]).reshape(-1, 2, 3),
        low=np.concatenate([NO_SHAPE.low, *(one.low for one in every)]),
        high=np.concatenate([NO_SHAPE.high, *(one.high for one in every)]),
        is_top=np.concatenate([NO_SHAPE.is_top, *(one.is_top for one in every)]),
        of=np.repeat(np.arange(len(every)), [len(one.voxels) for one in every]),
    )


def gaps(a_low: Float64, a_high: Float64, b_low: Float64, b_high: Float64) -> Float64:
    """Return the distances (N, M) between boxes (N, D) and boxes (M, D)."""
    apart = np.maximum(a_low[:, None] - b_high[None], b_low[None] - a_high[:, None])
    np.maximum(apart, 0.0, out=apart)
    distances: Float64 = np.sqrt(np.einsum("nmd,nmd->nm", apart, apart))
    return distances


def within_reach(low: Float64, high: Float64, box: Float64, reach_m: float) -> Bool:
    """Tell which boxes (N, D) come within ``reach_m`` of ``box`` (2, D) along every axis."""
    close = (low <= box[1] + reach_m) & (high >= box[0] - reach_m)
    return np.asarray(close.all(axis=1))


def _trimmed(low: Float64, voxels: Float64) -> float:
    """Return where the patches begin, but for the first ``_TRIMMED`` of the voxels."""
    order = np.argsort(low, kind="stable")
    reached = np.cumsum(voxels.take(order))
    return float(low[order[np.searchsorted(reached, _TRIMMED * reached[-1], side="right")]])
