"""Noise whose neighbouring pixels resemble each other."""

from functools import cache
from statistics import NormalDist

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32

REACH = 4  # standard deviations from the middle to the end of a window
PATCH_PX = 1.0


def grain(shape: tuple[int, ...], size_px: float, rng: np.random.Generator) -> Float32:
    """Return normal noise of unit variance, (H, W) or (H, W, C), with a Gaussian correlation."""
    white = rng.standard_normal(shape, np.float32)
    if size_px <= 0:
        return white
    window = _window(size_px)
    return np.asarray(cv2.sepFilter2D(white, -1, window, window), np.float32)


def patches(shape: tuple[int, ...], share: float, rng: np.random.Generator) -> Bool:
    """Return spots of a few pixels that cover about ``share`` of an image."""
    noise = grain(shape, PATCH_PX, rng)
    if not 0 < share < 1:
        return np.full(shape, share >= 1)
    return noise > np.float32(NormalDist().inv_cdf(1 - share))


@cache
def _window(size_px: float) -> Float32:
    """Return one axis of a Gaussian window that keeps the variance of white noise."""
    kernel = cv2.getGaussianKernel(2 * int(np.ceil(REACH * size_px)) + 1, size_px, cv2.CV_32F)
    return np.asarray(kernel / np.linalg.norm(kernel), np.float32)
