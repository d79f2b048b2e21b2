"""What becomes of the map when the poses it was made with turn out to have been wrong.

Every voxel remembers its *anchor*, the keyframe that first saw its surface. When the pose of that
keyframe changes from T_old to T_new, the surface moves by T_new T_old^-1.
"""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int32, Int64
from sceneq_core.checks import need_between
from sceneq_core.mapping.rows import first_of_each, with_rows
from sceneq_core.mapping.voxels import Moved, Voxels

RIGID = 1e-3
"""How far R^T R may be from the identity: poses that were rounded to four digits pass."""


@dataclass(frozen=True, slots=True)
class Correction:
    """The poses of frames as they are known now; frames that are not named keep theirs.

    ``seq`` int64 (N,) of the frames, ``T_world_camera`` float64 (N, 4, 4), metres.
    """

    seq: Int64
    T_world_camera: Float64


@dataclass(frozen=True, slots=True)
class CorrectionParams:
    """When two groups are one thing that was mapped twice.

    ``min_share`` of the surface of one lies in the voxels of the other, and no view tells the two
    apart; or ``sure_share``, whatever views said that were related by wrong poses.
    """

    min_share: float = 0.4
    sure_share: float = 0.7

    def __post_init__(self) -> None:
        need_between(self, 0, 1, "min_share", "sure_share")


@dataclass(frozen=True, slots=True)
class Absorbed:
    """Each ``group`` int32 (P,) lies mostly ``into`` (P,) another, some ``sure`` bool (P,)."""

    group: Int32
    into: Int32
    sure: Bool


@dataclass(frozen=True, slots=True)
class Motions:
    """How anchors moved: ``moved`` bool (A,), ``T_new_old`` float64 (A, 4, 4), world frame."""

    moved: Bool
    T_new_old: Float64


class Anchors:
    """The keyframes of the map, numbered from 0, and the poses their surface lies by now."""

    def __init__(self) -> None:
        self._count = 0
        self._number: dict[int, int] = {}
        self._T_world_camera = np.zeros((0, 4, 4))

    def add(self, seq: int, T_world_camera: Float64) -> int:
        """Return the number of keyframe ``seq``; a seq that comes again gets a new one."""
        number, self._count = self._count, self._count + 1
        self._T_world_camera = with_rows(self._T_world_camera, self._count, 0.0)
        self._T_world_camera[number] = T_world_camera
        self._number[seq] = number
        return number

    def motions(self, correction: Correction) -> Motions:
        """Return how ``correction`` moves the anchors; frames that are none are left out.

        Raises:
            ValueError: arrays of different length, or a pose that is no rigid motion.
        """
        _check(correction)
        T_new_old = np.tile(np.eye(4), (self._count, 1, 1))
        moved = np.zeros(self._count, np.bool_)
        for seq, T_new in zip(correction.seq.tolist(), correction.T_world_camera, strict=True):
            number = self._number.get(seq, -1)
            if number >= 0:
                T_old = self._T_world_camera[number]
                moved[number] = not np.array_equal(T_new, T_old)
                T_new_old[number] = T_new @ np.linalg.inv(T_old)
        return Motions(moved, T_new_old)

    def take(self, correction: Correction) -> None:
        """Let the poses of ``correction`` be those of the anchors."""
        for seq, T_new in zip(correction.seq.tolist(), correction.T_world_camera, strict=True):
            if seq in self._number:
                self._T_world_camera[self._number[seq]] = T_new


def move_surface(voxels: Voxels, motions: Motions) -> Moved:
    """Move every voxel by the motion of its anchor.

    Raises:
        ValueError: the surface would leave the grid; nothing has moved then.
    """
    every = voxels.occupied(np.arange(len(voxels), dtype=np.int32))
    anchor = voxels.anchor[every]
    going = motions.moved[anchor]
    return voxels.move(every[going], motions.T_new_old[anchor[going]])


def absorbed(before: Int32, after: Int32, params: CorrectionParams) -> Absorbed:
    """Return the groups of which much surface is in another group's voxels now.

    ``before`` and ``after`` int32 (N,) are the groups that every piece of surface belonged to and,
    where it is now, belongs to; -1 = none.
    """
    size = np.bincount(before[before >= 0], minlength=1)
    lost = (before >= 0) & (after >= 0) & (before != after)
    span = int(after.max(initial=0)) + 1
    pair, count = np.unique(before[lost] * np.int64(span) + after[lost], return_counts=True)
    share = count / size[pair // span]
    most = first_of_each(np.lexsort((pair, -share)), pair // span)
    most = most[share[most] >= params.min_share]
    group, into = pair[most] // span, pair[most] % span
    sure = share[most] >= params.sure_share
    return Absorbed(group.astype(np.int32), into.astype(np.int32), sure)


def _check(correction: Correction) -> None:
    poses = correction.T_world_camera
    if poses.shape != (len(correction.seq), 4, 4):
        raise ValueError(f"T_world_camera: {poses.shape} for {len(correction.seq)} frames")
    if not np.isfinite(poses).all():
        raise ValueError("T_world_camera: not finite")
    rotation = poses[:, :3, :3]
    off = np.abs(rotation.transpose(0, 2, 1) @ rotation - np.eye(3)).max(initial=0.0)
    if off > RIGID or not (np.linalg.det(rotation) > 0).all():
        raise ValueError(f"T_world_camera: not rigid, R^T R is off by {off:.2g}")
    if (poses[:, 3] != (0.0, 0.0, 0.0, 1.0)).any():
        raise ValueError("T_world_camera: the last row is not 0 0 0 1")
