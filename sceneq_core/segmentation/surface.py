"""Where a depth image is smooth, where it jumps and where it folds inwards."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Array, Bool, Float32, Float64, UInt8
from sceneq_core.depth import pixel_rays
from sceneq_core.segmentation.working_image import WorkingImage

_SLOPE_BASE_PX = 2
_FOLD_BASE_PX = 3
_CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
_NEAR = np.ones((7, 7), np.uint8)
_FAR_AWAY = np.float32(1e6)
_OBLIQUE = np.float32(np.sin(np.pi / 8))


@dataclass(frozen=True, slots=True)
class Surface:
    """The visible surface of a working image.

    Attributes:
        closeness: float32 (h, w), 1/m, denoised, 0 = no measurement.
        K: float64 (3, 3), pixels.
        normals_camera: float32 (3, h, w), unit, towards the camera.
        facing: uint8 (h, w), which of 26 directions over the sphere the normal is near to.
        steps: bool (h, w), beside a depth discontinuity.
        creases: bool (h, w), on a concave fold, such as where an object stands on a table.
    """

    closeness: Float32
    K: Float64
    normals_camera: Float32
    facing: UInt8
    steps: Bool
    creases: Bool

    def inside(self, window: tuple[slice, slice]) -> "Surface":
        """Return the part of the surface in ``window``, with the pixels counted from its corner."""
        rows, columns = window
        K = self.K - np.array([[0, 0, columns.start], [0, 0, rows.start], [0, 0, 0]])
        return Surface(
            self.closeness[window],
            K,
            self.normals_camera[:, *window],
            self.facing[window],
            self.steps[window],
            self.creases[window],
        )


def surface_of(image: WorkingImage, noise: float, min_fold_deg: float) -> Surface:
    """Return the surface of ``image``; ``noise`` is the depth error in 1/m."""
    denoised = cv2.bilateralFilter(image.closeness, 7, 4 * noise, 2.0)
    closeness = np.asarray(denoised, np.float32)
    closeness[~image.measured] = 0
    slopes = _slopes(closeness)
    steps = _steps(closeness, slopes, 6 * noise)
    smooth = image.measured & ~steps
    slopes = [_smoothed(slope, smooth) for slope in slopes]
    normals = _normals(closeness, slopes, image)
    creases = _creases(closeness, normals, smooth, image, min_fold_deg)
    return Surface(closeness, image.K, normals, _facing(normals), steps, creases)


def _rays(image: WorkingImage) -> tuple[Float32, Float32]:
    """Return x / z (1, w) and y / z (h, 1) of the pixels."""
    x, y = pixel_rays(image.K, image.closeness.shape)
    return x[None].astype(np.float32), y[:, None].astype(np.float32)


def _slopes(closeness: Float32) -> list[Float32]:
    """Return the change per pixel along x and y, (h, w) each; the border takes the next inside."""
    return [_slope(closeness.T).T, _slope(closeness)]


def _slope(closeness: Float32) -> Float32:
    base, height = _SLOPE_BASE_PX, closeness.shape[0]
    if height <= 2 * base:
        return np.zeros_like(closeness)
    change = (closeness[2 * base :] - closeness[: -2 * base]) / np.float32(2 * base)
    return np.pad(change, ((base, base), (0, 0)), mode="edge")


def _steps(closeness: Float32, slopes: list[Float32], threshold: float) -> Bool:
    """Return where the change over a pixel exceeds what the slope of the neighbourhood explains.

    The slope is the least one nearby, because at the step itself it is contaminated by the step.
    """
    highest = cv2.dilate(closeness, _CROSS)
    lowest = cv2.erode(np.where(closeness > 0, closeness, _FAR_AWAY), _CROSS)
    steepest = np.maximum(np.abs(slopes[0]), np.abs(slopes[1]))
    explained = 2 * cv2.erode(np.ascontiguousarray(steepest), _NEAR)
    return np.asarray((highest - lowest - explained > threshold) & (closeness > 0))


def _smoothed(values: Float32, where: Bool) -> Float32:
    """Return the 5 x 5 mean of ``values`` over the pixels of ``where``."""
    weight = cv2.blur(where.astype(np.float32), (5, 5))
    return np.asarray(cv2.blur(values * where, (5, 5)) / np.maximum(weight, 1e-6))


def _normals(closeness: Float32, slopes: list[Float32], image: WorkingImage) -> Float32:
    """Return unit normals: the plane n . p = 1 has closeness n . (x, y, 1) along the ray."""
    x, y = _rays(image)
    n_x = slopes[0] * np.float32(image.K[0, 0])
    n_y = slopes[1] * np.float32(image.K[1, 1])
    away = np.stack([n_x, n_y, closeness - n_x * x - n_y * y])
    return np.asarray(-away / np.maximum(np.sqrt(_dot(away, away)), 1e-9))


def _facing(normals: Float32) -> UInt8:
    """Return a number for the side, middle or other side each component of the normal is on."""
    facing = np.zeros(normals.shape[1:], np.uint8)
    for component in normals:
        facing *= 3
        facing += component > -_OBLIQUE
        facing += component > _OBLIQUE
    return facing


def _dot(a: Array, b: Array) -> Array:
    """Return the scalar products (h, w) of vectors (3, h, w)."""
    products: Array = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return products


def _creases(
    closeness: Float32, normals: Float32, smooth: Bool, image: WorkingImage, min_fold_deg: float
) -> Bool:
    """Return where the normals on both sides lean towards each other by ``min_fold_deg``."""
    depth = np.where(closeness > 0, 1 / np.maximum(closeness, 1e-6), 0)
    x, y = _rays(image)
    points = np.stack([x * depth, y * depth, depth])
    creases = np.zeros(closeness.shape, bool)
    for axis in (0, 1):
        if closeness.shape[axis] > 2 * _FOLD_BASE_PX:
            creases |= _folds(points, normals, smooth, axis, float(np.deg2rad(min_fold_deg)))
    return creases


def _folds(points: Array, normals: Array, smooth: Bool, axis: int, min_fold: float) -> Bool:
    base = _FOLD_BASE_PX
    before, after, middle = (
        (slice(None),) * axis + (part,)
        for part in (slice(None, -2 * base), slice(2 * base, None), slice(base, -base))
    )
    turn = normals[:, *after] - normals[:, *before]
    across = points[:, *after] - points[:, *before]
    leaning = _dot(turn, across) < 0
    wide = _dot(turn, turn) > (2 * np.sin(min_fold / 2)) ** 2
    folds = np.zeros(smooth.shape, bool)
    folds[middle] = leaning & wide & smooth[before] & smooth[after]
    return folds
