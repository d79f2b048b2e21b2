"""What each superpoint looks like as one small flat piece: place, extent, direction, colour."""

import cv2
import numpy as np

from sceneq_core.arrays import Array, Float64, Int32
from sceneq_core.mapping.rows import distinct, stable_order, with_rows
from sceneq_core.mapping.superpoints import Superpoints
from sceneq_core.mapping.voxels import Voxels
from sceneq_core.vectors import unit_rows


class Patches:
    """Rows by superpoint id, 0 voxels where there is no such superpoint.

    Attributes:
        voxels: float64 (S,) how many voxels it has.
        centre_world: float64 (S, 3) mean position, metres.
        normal_world: float64 (S, 3) unit mean normal, towards where it was seen from.
        lab: float64 (S, 3) mean colour in CIELAB, lightness counted by half as shading changes it.
        low_world, high_world: float64 (S, 3) corners of its axis-aligned box, metres.
    """

    def __init__(self) -> None:
        self.voxels = np.zeros(0)
        self.centre_world = np.zeros((0, 3))
        self.normal_world = np.zeros((0, 3))
        self.lab = np.zeros((0, 3))
        self.low_world = np.zeros((0, 3))
        self.high_world = np.zeros((0, 3))

    def update(
        self, voxels: Voxels, superpoints: Superpoints, voxel_id: Int32, gone_id: Int32
    ) -> Int32:
        """Measure anew the superpoints of ``voxel_id``, all of whose voxels are among them.

        Returns the changed superpoint ids, ``gone_id`` included.
        """
        self._reserve(len(superpoints))
        self.voxels[gone_id] = 0.0
        owner = superpoints.of(voxel_id)
        owned = np.flatnonzero(owner >= 0)
        owned = owned.take(stable_order(owner.take(owned)))
        changed = distinct(owner.take(owned), len(superpoints))
        if len(owned):
            self._measure(voxels, voxel_id.take(owned), owner.take(owned), changed)
        return distinct(np.concatenate((changed, gone_id)), len(superpoints))

    def _measure(self, voxels: Voxels, voxel_id: Int32, owner: Int32, changed: Int32) -> None:
        """Take the mean over each run of equal ``owner``."""
        start = np.searchsorted(owner, changed)
        points, rgb, normals = voxels.means_and_normals(voxel_id)
        count = np.diff(start, append=len(owner)).astype(np.float64)
        self.voxels[changed] = count
        self.centre_world[changed] = _means(points, start, count)
        self.normal_world[changed] = unit_rows(np.add.reduceat(normals, start, axis=0))
        self.low_world[changed] = np.minimum.reduceat(points, start, axis=0)
        self.high_world[changed] = np.maximum.reduceat(points, start, axis=0)
        self.lab[changed] = _half_lightness(_means(rgb, start, count))

    def _reserve(self, count: int) -> None:
        self.voxels = with_rows(self.voxels, count, 0.0)
        self.centre_world = with_rows(self.centre_world, count, 0.0)
        self.normal_world = with_rows(self.normal_world, count, 0.0)
        self.lab = with_rows(self.lab, count, 0.0)
        self.low_world = with_rows(self.low_world, count, 0.0)
        self.high_world = with_rows(self.high_world, count, 0.0)


def _means(rows: Array, start: Array, count: Float64) -> Float64:
    means: Float64 = np.add.reduceat(rows.astype(np.float64), start, axis=0) / count[:, None]
    return means


def _half_lightness(rgb: Float64) -> Float64:
    lab = cv2.cvtColor((rgb[None] / 255.0).astype(np.float32), cv2.COLOR_RGB2LAB)[0]
    scaled: Float64 = lab.astype(np.float64) * np.array([0.5, 1.0, 1.0])
    return scaled
