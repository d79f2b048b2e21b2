"""The frame at the resolution segmentation works at, in the units it works in."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Array, Bool, Float32, Float64
from sceneq_core.frame import Frame


@dataclass(frozen=True, slots=True)
class WorkingImage:
    """A frame, reduced.

    Attributes:
        colour: CIELAB float32 (h, w, 3), L 0..100.
        closeness: float32 (h, w), inverse depth in 1/m, 0 = no measurement. Triangulating depth
            sensors have the same error everywhere in this unit, and a plane is affine in it.
        K: float64 (3, 3), pixels of the reduced image.
        step: pixels of the frame per pixel of the reduced image, along both axes.
    """

    colour: Float32
    closeness: Float32
    K: Float64
    step: int

    @property
    def measured(self) -> Bool:
        """Where there is depth, bool (h, w)."""
        return np.asarray(self.closeness > 0)


def reduced(frame: Frame, width: int) -> WorkingImage:
    """Return ``frame`` at most ``width`` pixels wide.

    Colour is averaged; depth is the median of the measurements under each pixel, because the mean
    of two surfaces is a point on neither.
    """
    height_full, width_full = frame.depth_m.shape
    step = max(1, -(-width_full // width))
    size = (-(-width_full // step), -(-height_full // step))
    rgb = cv2.resize(frame.rgb, size, interpolation=cv2.INTER_AREA)
    K = np.diag([1 / step, 1 / step, 1.0]) @ frame.K
    K[:2, 2] += 0.5 / step - 0.5
    lab = cv2.cvtColor(rgb.astype(np.float32) / np.float32(255), cv2.COLOR_RGB2LAB)
    colour = np.asarray(lab, np.float32)
    return WorkingImage(colour, _closeness(frame.depth_m, step), K, step)


def enlarged(labels: Array, step: int, shape: tuple[int, int]) -> Array:
    """Return ``labels`` repeated ``step`` times along both axes, cut to the full ``shape``."""
    full = labels.repeat(step, axis=0).repeat(step, axis=1)
    return full[: shape[0], : shape[1]]


def _closeness(depth_m: Float32, step: int) -> Float32:
    """Return the inverse of the middle measurement in each ``step`` x ``step`` block."""
    height, width = depth_m.shape
    padded = np.pad(depth_m, ((0, -height % step), (0, -width % step)))
    ordered = _ordered([padded[v::step, u::step] for v in range(step) for u in range(step)])
    missing = np.count_nonzero(ordered <= 0, axis=0)
    middle = np.minimum((missing + step * step) // 2, step * step - 1)
    depth: Float32 = np.take_along_axis(ordered, middle[None], axis=0)[0]
    closeness = np.zeros_like(depth)
    np.divide(1, depth, out=closeness, where=depth > 0)
    return closeness


def _ordered(images: list[Float32]) -> Float32:
    """Return ``images`` (n, h, w) sorted at every pixel, by exchanging neighbours.

    For the few images there are, whole-image exchanges are far faster than a sort per pixel.
    """
    ordered = np.stack(images)
    for last in range(len(ordered) - 1, 0, -1):
        for i in range(last):
            low, high = ordered[i], ordered[i + 1]
            ordered[i], ordered[i + 1] = np.minimum(low, high), np.maximum(low, high)
    return ordered
