"""Things without a shape: posters, magazines and screens, told from their plane by colour."""

import cv2
import numpy as np

from sceneq_core.arrays import Array, Bool, Float32, Int32
from sceneq_core.segmentation.graph_segments import graph_segments
from sceneq_core.segmentation.piece import window_of

_WHOLE_FILL = 0.7
_PART_SHARE = 0.2
_BRIDGE = np.ones((3, 3), np.uint8)


def flats_of(
    colour: Float32, planes: Int32, blank: Bool, scale: float, contrast: float, min_pixels: int
) -> Int32:
    """Return flat things int32 (h, w), 0 = none.

    Searched inside every plane of ``planes`` (> 0), where the commonest colour is the plane's own
    and a thing differs from it by ``contrast`` (CIELAB), and where ``blank``, which has no own
    colour: there every region is a thing.
    """
    domain = np.where(blank, 0, np.where(planes > 0, planes, -1)).astype(np.int32)
    regions = graph_segments(colour, domain, scale, min_pixels)
    things = np.zeros(domain.shape, np.int32)
    area = np.bincount(regions.reshape(-1))
    mean = _means(colour, regions, area)
    _number(things, blank & (area[regions] >= min_pixels), regions, 0)
    for plane in np.flatnonzero(np.bincount(planes.reshape(-1)))[1:]:
        window = window_of(domain == plane)
        inside, parts = domain[window] == plane, regions[window]
        own = _own_colour(parts[inside], mean)
        strange = inside & (np.linalg.norm(mean - own, axis=1) > contrast)[parts]
        pieces = _pieces(strange, colour[window], scale, min_pixels)
        _number(things[window], inside & (pieces > 0), pieces, int(things.max()))
    return things


def _means(colour: Float32, regions: Int32, area: Array) -> Array:
    flat = regions.reshape(-1)
    sums = [np.bincount(flat, weights=colour[..., c].reshape(-1)) for c in range(3)]
    return np.stack(sums, axis=1) / np.maximum(area, 1)[:, None]


def _own_colour(regions: Array, mean: Array) -> Array:
    """Return the colour of the largest region."""
    own: Array = mean[np.bincount(regions).argmax()]
    return own


def _pieces(where: Bool, colour: Float32, scale: float, min_pixels: int) -> Int32:
    """Return pieces (0 = too small): a whole patch if it is box-like, else its main colour parts.

    A printed page is many colours in one rectangle; pages that overlap make an odd outline.
    """
    pieces = np.zeros(where.shape, np.int32)
    opened = cv2.morphologyEx(where.astype(np.uint8), cv2.MORPH_OPEN, _BRIDGE)
    outlines, _ = cv2.findContours(opened, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    for outline in outlines:
        left, top, width, height = cv2.boundingRect(outline)
        patch = np.zeros((height, width), np.uint8)
        cv2.drawContours(patch, [outline], -1, 1, cv2.FILLED, offset=(-left, -top))
        area = int(patch.sum())
        if area < min_pixels:
            continue
        window = np.s_[top : top + height, left : left + width]
        parts = patch.astype(np.int32)
        if area < _WHOLE_FILL * _box_area(outline):
            smallest = max(min_pixels, round(_PART_SHARE * area))
            parts = graph_segments(colour[window], parts - 1, scale, smallest)
        _number(pieces[window], (patch > 0) & (pieces[window] == 0), parts, int(pieces.max()))
    return pieces


def _box_area(outline: Array) -> float:
    """Return the pixels of the tightest rotated rectangle round ``outline``."""
    _, (width, height), _ = cv2.minAreaRect(outline)
    return float((width + 1) * (height + 1))


def _number(things: Int32, where: Bool, ids: Int32, last: int) -> None:
    """Give every distinct id under ``where`` a number after ``last`` in ``things``."""
    chosen = ids[where]
    number = np.cumsum(np.bincount(chosen) > 0)
    things[where] = number[chosen] + last
