"""Pictures in the square that a network takes, and its maps back in the picture's pixels."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Array, Float32, Int64, UInt8
from sceneq_core.encoding.resample import resample


@dataclass(frozen=True, slots=True)
class Letterbox:
    """A picture of ``height`` x ``width`` that lies at ``top``, ``left`` in a larger one, resized
    to ``inner_height`` x ``inner_width``; all in pixels.
    """

    height: int
    width: int
    inner_height: int
    inner_width: int
    top: int = 0
    left: int = 0

    def placed(self, rgb: UInt8, size: tuple[int, int], fill: int) -> UInt8:
        """Return ``rgb`` (height, width, 3) in a picture of ``size``, the rest grey ``fill``."""
        whole = np.full((*size, 3), fill, np.uint8)
        bottom, right = self.top + self.inner_height, self.left + self.inner_width
        whole[self.top : bottom, self.left : right] = self.inner(rgb)
        return whole

    def inner(self, rgb: UInt8) -> UInt8:
        """Return ``rgb`` resized, uint8 (inner_height, inner_width, 3), without aliases."""
        if self.inner_height >= self.height and self.inner_width >= self.width:
            size = self.inner_width, self.inner_height
            return np.asarray(cv2.resize(rgb, size, interpolation=cv2.INTER_LINEAR), np.uint8)
        return resample(rgb, (self.inner_height, self.inner_width), "bilinear")

    def points(self, xy: Float32) -> Float32:
        """Return points (N, 2) of the picture in pixels of the larger one."""
        scale = self.inner_width / self.width, self.inner_height / self.height
        return np.asarray(xy * scale + (self.left, self.top), np.float32)

    def restored(self, values: Array, size: tuple[int, int], *, nearest: bool = False) -> Array:
        """Return a map over the larger picture of ``size``, at any resolution, as (height, width).

        ``values`` (h, w); between its pixels linearly, or ``nearest``.
        """
        down, across = values.shape[0] / size[0], values.shape[1] / size[1]
        step_x = across * self.inner_width / self.width
        step_y = down * self.inner_height / self.height
        first_x = 0.5 * step_x + self.left * across - 0.5
        first_y = 0.5 * step_y + self.top * down - 0.5
        if nearest:
            column = _nearest(first_x, step_x, self.width, values.shape[1])
            row = _nearest(first_y, step_y, self.height, values.shape[0])
            return np.ascontiguousarray(values[row[:, None], column[None]])
        return cv2.warpAffine(
            values,
            np.array([[step_x, 0, first_x], [0, step_y, first_y]]),
            (self.width, self.height),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )


def fitted(height: int, width: int, size: tuple[int, int], *, centred: bool) -> Letterbox:
    """Return where a picture lies that keeps its aspect in a larger one of ``size``."""
    ratio = min(size[0] / height, size[1] / width)
    inner = min(size[0], max(1, round(height * ratio))), min(size[1], max(1, round(width * ratio)))
    top, left = ((size[0] - inner[0]) // 2, (size[1] - inner[1]) // 2) if centred else (0, 0)
    return Letterbox(height, width, *inner, top, left)


def squashed(height: int, width: int, size: tuple[int, int]) -> Letterbox:
    """Return a picture resized to ``size``, whatever its aspect."""
    return Letterbox(height, width, *size)


def _nearest(first: float, step: float, count: int, among: int) -> Int64:
    place = np.floor(first + step * np.arange(count) + 0.5).astype(np.int64)
    return np.asarray(np.clip(place, 0, among - 1), np.int64)
