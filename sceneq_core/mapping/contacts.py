"""Which superpoints lie side by side in a keyframe, and where the surface goes on between them."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Array, Float32, Float64, Int32, Int64
from sceneq_core.mapping.rows import distinct
from sceneq_core.mapping.surface import SurfacePoints
from sceneq_core.mapping.voxels import Voxels

_SHIFT = 32
_LOW = (1 << _SHIFT) - 1
_REACH_VOXELS = 2.0
"""Neighbouring pixels farther apart, in voxels, show two surfaces, one behind the other."""
_INWARDS = -0.3
"""Sine of the angle from which a surface makes an inner corner: 17 degrees between two voxels is
more than the noise of their normals, and less than what objects make with what they stand on."""
_OTHER_COLOUR = 10.0
"""CIELAB difference that two neighbouring voxels of one thing seldom have: twice what a superpoint
bears, four times what an eye can tell apart."""


@dataclass(frozen=True, slots=True)
class Contacts:
    """Pairs of superpoints side by side, int32 (C,), ``first`` < ``second``, no pair twice.

    ``length`` int64 (C,) counts the pairs of neighbouring surface points along their border, and
    ``unbent`` int64 (C,) those between which the surface goes on: it makes no inner corner, and
    has no other colour, as a picture has on its wall. Things mostly bulge, and meet one another in
    inner corners (Stein et al., Object Partitioning using Local Convexity, CVPR 2014,
    doi:10.1109/CVPR.2014.46).
    """

    first: Int32
    second: Int32
    length: Int64
    unbent: Int64


NO_CONTACTS = Contacts(
    np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros(0, np.int64), np.zeros(0, np.int64)
)


def contacts_in_view(
    superpoint: Int32, voxel_id: Int32, surface: SurfacePoints, stride_px: int, voxels: Voxels
) -> Contacts:
    """Return the contacts that one keyframe shows.

    ``superpoint`` int32 (N,), -1 = none, and ``voxel_id`` int32 (N,) are parallel to ``surface``,
    of which every ``stride_px``-th pixel was measured.
    """
    near, far = _borders(superpoint, surface.row // stride_px, surface.column // stride_px)
    points_world = surface.points_world
    step_world = points_world.take(far, axis=0) - points_world.take(near, axis=0)
    gap_m = np.sqrt(_row_sums(step_world**2))
    close = np.flatnonzero(gap_m < _REACH_VOXELS * voxels.voxel_size_m)
    near, far, gap_m = near.take(close), far.take(close), gap_m.take(close)
    turn, tint = _differences(voxels, voxel_id.take(near), voxel_id.take(far))
    unbent = _row_sums(turn * step_world.take(close, axis=0)) >= _INWARDS * gap_m
    unbent &= _row_sums(tint**2) < _OTHER_COLOUR**2
    one, other = superpoint.take(near).astype(np.int64), superpoint.take(far)
    key, pair = np.unique(
        np.minimum(one, other) << _SHIFT | np.maximum(one, other), return_inverse=True
    )
    return Contacts(
        first=(key >> _SHIFT).astype(np.int32),
        second=(key & _LOW).astype(np.int32),
        length=np.bincount(pair, minlength=len(key)).astype(np.int64),
        unbent=np.bincount(pair[unbent], minlength=len(key)).astype(np.int64),
    )


def _looks(voxels: Voxels, voxel_id: Int32) -> tuple[Float64, Float32]:
    """Return normals and CIELAB colours (N, 3); half of lightness, because shading changes it."""
    normals_world, rgb = voxels.features(voxel_id)
    lab = cv2.cvtColor(rgb.reshape(1, -1, 3), cv2.COLOR_RGB2LAB)[0] if len(rgb) else rgb
    return normals_world, np.asarray(lab * np.array((0.5, 1.0, 1.0), np.float32))


def _differences(voxels: Voxels, near_id: Int32, far_id: Int32) -> tuple[Float64, Float32]:
    """Return by how much normals and colours (N, 3) of pairs of voxels differ.

    A voxel lies on more than one border: what it looks like is worked out once.
    """
    voxel_id = distinct(np.concatenate((near_id, far_id)), len(voxels))
    row = np.empty(len(voxels), np.int32)
    row[voxel_id] = np.arange(len(voxel_id), dtype=np.int32)
    near, far = row.take(near_id), row.take(far_id)
    normals_world, lab = _looks(voxels, voxel_id)
    turn = normals_world.take(far, axis=0) - normals_world.take(near, axis=0)
    return turn, lab.take(far, axis=0) - lab.take(near, axis=0)


def _row_sums(rows: Array) -> Array:
    """Return the sums of rows (N, 3); for so few columns quicker than ``sum``."""
    sums: Array = rows[:, 0] + (rows[:, 1] + rows[:, 2])
    return sums


def _borders(superpoint: Int32, row: Int32, column: Int32) -> tuple[Int32, Int32]:
    """Return the points to both sides of all borders between superpoints in the image."""
    shape = int(row.max(initial=-1)) + 1, int(column.max(initial=-1)) + 1
    image, point = np.full(shape, -1, np.int32), np.zeros(shape, np.int32)
    pixel = row * shape[1] + column
    image.reshape(-1)[pixel] = superpoint
    point.reshape(-1)[pixel] = np.arange(len(row), dtype=np.int32)
    near, far = [], []
    for one, other in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        border = (image[one] != image[other]) & (image[one] >= 0) & (image[other] >= 0)
        near.append(point[one][border])
        far.append(point[other][border])
    return np.concatenate(near), np.concatenate(far)
