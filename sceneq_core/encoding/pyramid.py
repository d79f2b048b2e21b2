"""Crops of one object at several sizes: tight first, then with more of its surroundings."""

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, UInt8
from sceneq_core.encoding.encoder import Crop
from sceneq_core.views.view import View

Box = tuple[int, int, int, int]


def expanded(box_xyxy: Float32, ratio: float, size: tuple[int, int]) -> Box:
    """Return the pixels (left, top, right, bottom) of a box grown by ``ratio`` of its edges.

    Half of the growth goes to either side. The result lies within the image of ``size`` (height,
    width) and holds at least one pixel.
    """
    x0, y0, x1, y1 = (float(value) for value in box_xyxy)
    dx, dy = ratio * (x1 - x0) / 2, ratio * (y1 - y0) / 2
    left, right = _span(x0 - dx, x1 + dx, size[1])
    top, bottom = _span(y0 - dy, y1 + dy, size[0])
    return left, top, right, bottom


def pyramid(rgb: UInt8, view: View, levels: int, expand: float) -> list[Crop]:
    """Return ``levels`` crops of the view's box, level l grown by ``l * expand``.

    ``rgb`` uint8 (H, W, 3) is the keyframe; every crop carries the object's mask.
    """
    size = (rgb.shape[0], rgb.shape[1])
    mask = full_mask(view, size)
    boxes = [expanded(view.box_xyxy, level * expand, size) for level in range(levels)]
    areas = [np.s_[top:bottom, left:right] for left, top, right, bottom in boxes]
    return [Crop(rgb[area], mask[area]) for area in areas]


def full_mask(view: View, size: tuple[int, int]) -> Bool:
    """Return the view's mask in the whole image, bool (height, width).

    The view carries it for its box only, at half resolution.
    """
    left, top, right, bottom = expanded(view.box_xyxy, 0.0, size)
    mask = np.zeros(size, np.bool_)
    if view.mask.size:
        box_mask = cv2.resize(
            view.mask.astype(np.uint8),
            (right - left, bottom - top),
            interpolation=cv2.INTER_NEAREST,
        )
        mask[top:bottom, left:right] = box_mask > 0
    return mask


def _span(low: float, high: float, size: int) -> tuple[int, int]:
    """Return whole pixels [start, end) around low..high within [0, size), at least one."""
    start = min(max(0, int(np.floor(low))), size - 1)
    end = max(min(size, int(np.ceil(high))), start + 1)
    return start, end
