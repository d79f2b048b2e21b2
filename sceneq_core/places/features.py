"""Points of a picture that are known again from elsewhere, where in space they are, and pairs."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Float32, Float64, Int64, UInt8
from sceneq_core.checks import need_at_least, need_between
from sceneq_core.places.place import Place


@dataclass(frozen=True, slots=True)
class FeatureParams:
    """``most`` features a picture, the strongest, ``first`` of them to look for candidates.

    ``contrast`` they need against what is around them: half of what is usual, for walls are plain.
    ``ratio``: how much nearer (as descriptors go) the best match is than the second best. Lowe
    2004, DOI 10.1023/B:VISI.0000029664.99615.94.
    """

    most: int = 600
    first: int = 200
    contrast: float = 0.02
    ratio: float = 0.8

    def __post_init__(self) -> None:
        need_at_least(self, 8, "most", "first")
        need_between(self, 0, 1, "contrast", "ratio")


@dataclass(frozen=True, slots=True)
class Features:
    """``points_camera`` float64 (N, 3), metres; ``descriptors`` uint8 (N, 128), strongest first.

    Whole numbers: sums of their products are exact however they are added up.
    """

    points_camera: Float64
    descriptors: UInt8

    def strongest(self, count: int) -> "Features":
        """Return the first ``count``."""
        return Features(self.points_camera[:count], self.descriptors[:count])


def features_of(place: Place, params: FeatureParams) -> Features:
    """Return the SIFT features that lie on measured surface."""
    finder = cv2.SIFT.create(nfeatures=params.most, contrastThreshold=params.contrast)
    keypoints, descriptors = finder.detectAndCompute(place.grey(), None)
    if not keypoints:
        return Features(np.zeros((0, 3)), np.zeros((0, 128), np.uint8))
    strength = np.array([keypoint.response for keypoint in keypoints])
    order = np.argsort(-strength, kind="stable")[: params.most]
    pixel = np.array([keypoint.pt for keypoint in keypoints], np.float64)[order]
    points, measured = _points(place, pixel)
    return Features(points, np.asarray(descriptors, np.uint8)[order][measured])


def pairs(one: Features, other: Features, ratio: float) -> Int64:
    """Return rows (P, 2) of features of ``one`` and ``other`` that are each other's best match."""
    if min(len(one.descriptors), len(other.descriptors)) < 2:
        return np.zeros((0, 2), np.int64)
    squared = _squared_distance(one.descriptors, other.descriptors)
    row = np.arange(len(squared))
    best = squared.argmin(axis=1)
    nearest = squared[row, best]
    mutual = squared.argmin(axis=0)[best] == row
    squared[row, best] = np.inf
    clear = nearest < ratio**2 * squared.min(axis=1)
    kept = np.flatnonzero(mutual & clear)
    return np.stack((kept, best[kept]), axis=1)


def _squared_distance(some: UInt8, others: UInt8) -> Float32:
    one, other = some.astype(np.float32), others.astype(np.float32)
    length = (one * one).sum(axis=1)[:, None] + (other * other).sum(axis=1)
    return np.asarray(length - 2.0 * (one @ other.T), np.float32)


def _points(place: Place, pixel: Float64) -> tuple[Float64, Int64]:
    """Return the points (M, 3) in space of pixels (N, 2), and the rows of those with a depth."""
    ray = (pixel - place.K[:2, 2]) / np.diag(place.K)[:2]
    at = np.rint(ray * np.diag(place.K_depth)[:2] + place.K_depth[:2, 2]).astype(np.intp)
    height, width = place.depth_mm.shape
    inside = (at >= 0).all(axis=1) & (at[:, 0] < width) & (at[:, 1] < height)
    row = np.flatnonzero(inside)
    z = place.depth_mm[at[row, 1], at[row, 0]] * 1e-3
    row, z = row[z > 0], z[z > 0]
    points = np.concatenate((ray[row], np.ones((len(row), 1))), axis=1) * z[:, None]
    return points, row
