"""Which superpoints lie side by side in a keyframe, and where the surface goes on between them."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Float32, Float64, Int32, Int64
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
    step_world = surface.points_world[far] - surface.points_world[near]
    gap_m = np.sqrt((step_world**2).sum(axis=1))
    close = gap_m < _REACH_VOXELS * voxels.voxel_size_m
    near, far, step_world, gap_m = near[close], far[close], step_world[close], gap_m[close]
    one, other = (_looks(voxels, voxel_id[end]) for end in (near, far))
    unbent = ((other[0] - one[0]) * step_world).sum(axis=1) >= _INWARDS * gap_m
    unbent &= ((other[1] - one[1]) ** 2).sum(axis=1) < _OTHER_COLOUR**2
    ends = np.sort(np.stack((superpoint[near], superpoint[far])), axis=0).astype(np.int64)
    key, pair = np.unique(ends[0] << _SHIFT | ends[1], return_inverse=True)
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


def _borders(superpoint: Int32, row: Int32, column: Int32) -> tuple[Int64, Int64]:
    """Return the points to both sides of all borders between superpoints in the image."""
    shape = int(row.max(initial=-1)) + 1, int(column.max(initial=-1)) + 1
    image, point = np.full(shape, -1, np.int32), np.zeros(shape, np.int64)
    image[row, column], point[row, column] = superpoint, np.arange(len(row))
    near, far = [], []
    for one, other in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        border = (image[one] != image[other]) & (image[one] >= 0) & (image[other] >= 0)
        near.append(point[one][border])
        far.append(point[other][border])
    return np.concatenate(near), np.concatenate(far)
