"""Planes in a depth image: affine functions of the pixel in inverse depth."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Array, Bool, Float32, Float64, UInt8
from sceneq_core.segmentation.surface import Surface

_REFITS = 30
_MIN_POINTS = 12
_MIN_SHARE = 0.3
_MAX_POINTS = 3000


@dataclass(frozen=True, slots=True)
class Plane:
    """closeness = coefficients . (u, v, 1), in 1/m with u, v in pixels."""

    coefficients: Float64

    def residual(self, closeness: Float32) -> Float32:
        """Return closeness minus the plane's, (h, w): positive is in front, towards the camera."""
        a, b, c = self.coefficients
        along_v = (b * np.arange(closeness.shape[0]) + c).astype(np.float32)
        along_u = (a * np.arange(closeness.shape[1])).astype(np.float32)
        return np.asarray(closeness - along_v[:, None] - along_u, np.float32)

    def normal_camera(self, K: Float64) -> Float64:
        """Return n (3,) with n . p = 1 for points p of the plane, metres, camera frame."""
        a, b, c = self.coefficients
        return np.array([a * K[0, 0], b * K[1, 1], a * K[0, 2] + b * K[1, 2] + c])

    def height_m(self, closeness: Float32, K: Float64) -> Float32:
        """Return the distance from the plane, (h, w), positive in front; 0 without measurement."""
        length = max(float(np.linalg.norm(self.normal_camera(K))), 1e-9)
        height = np.zeros_like(closeness)
        np.divide(self.residual(closeness), closeness * length, out=height, where=closeness > 0)
        return height


def fitted_plane(surface: Surface, where: Bool, noise: float) -> tuple[Plane, Bool] | None:
    """Return the plane that a good part of ``where`` lies on and its inliers, or ``None``.

    Begins with the largest patch that faces the commonest way, then refits to its better half
    until the pixels within three times the ``noise`` (1/m) are left: deterministic, no sampling.
    """
    v, u = np.nonzero(where)
    pixels = len(u)
    every = max(1, pixels // _MAX_POINTS)
    u, v = u[::every], v[::every]
    values = surface.closeness[v, u].astype(np.float64)
    design = np.stack([u, v, np.ones_like(u)]).astype(np.float64)
    keep = _seed(surface.facing, where)[v, u]
    for _ in range(_REFITS):
        if np.count_nonzero(keep) < _MIN_POINTS:
            return None
        plane = Plane(_solve(design, values, keep))
        residual = np.abs(values - plane.coefficients @ design)
        before, keep = keep, residual < max(3 * noise, _middle(residual[keep]))
        if np.array_equal(before, keep):
            break
    inliers = where & (np.abs(plane.residual(surface.closeness)) < 3 * noise)
    return (plane, inliers) if np.count_nonzero(inliers) >= _MIN_SHARE * pixels else None


def _seed(facing: UInt8, where: Bool) -> Bool:
    """Return the largest connected patch, (h, w), that faces the way most of ``where`` does."""
    commonest = np.bincount(facing[where]).argmax()
    alike = (where & (facing == commonest)).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(alike, connectivity=4)
    return np.asarray(labels == 1 + stats[1:, cv2.CC_STAT_AREA].argmax())


def _solve(design: Float64, values: Float64, keep: Bool) -> Float64:
    """Return the least-squares solution; the ridge keeps collinear pixels solvable."""
    kept = design * keep
    return np.asarray(np.linalg.solve(kept @ design.T + 1e-9 * np.eye(3), kept @ values))


def _middle(values: Array) -> float:
    """Return the middle one of ``values``, the upper of two."""
    half = len(values) // 2
    return float(np.partition(values, half)[half])
