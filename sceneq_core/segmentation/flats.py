"""Things without a shape: posters, magazines and screens, told from their plane by colour."""

import cv2
import numpy as np

from sceneq_core.arrays import Array, Bool, Float32, Int32
from sceneq_core.segmentation.graph_segments import graph_segments

_WHOLE_FILL = 0.75


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
    _number(things, blank & (area[regions] >= min_pixels), regions)
    for plane in np.unique(planes[planes > 0]):
        inside = domain == plane
        own = _own_colour(regions[inside], mean)
        strange = inside & (np.linalg.norm(mean - own, axis=1) > contrast)[regions]
        _number(things, strange, _pieces(strange, regions, min_pixels))
    return things


def _means(colour: Float32, regions: Int32, area: Array) -> Array:
    flat = regions.reshape(-1)
    sums = [np.bincount(flat, weights=colour[..., c].reshape(-1)) for c in range(3)]
    return np.stack(sums, axis=1) / np.maximum(area, 1)[:, None]


def _own_colour(regions: Array, mean: Array) -> Array:
    """Return the colour of the largest region."""
    ids, counts = np.unique(regions, return_counts=True)
    own: Array = mean[ids[np.argmax(counts)]]
    return own


def _pieces(where: Bool, regions: Int32, min_pixels: int) -> Int32:
    """Return pieces (0 = too small): a whole patch if it is box-like, else its colour regions.

    A printed page is many colours in one rectangle; pages that overlap make an odd outline.
    """
    count, patches, stats, _ = cv2.connectedComponentsWithStats(where.astype(np.uint8))
    pieces = np.zeros(where.shape, np.int32)
    for patch in range(1, count):
        area = stats[patch, cv2.CC_STAT_AREA]
        if area < min_pixels:
            continue
        inside = patches == patch
        if _fill(inside) >= _WHOLE_FILL:
            pieces[inside] = pieces.max() + 1
        else:
            _number(pieces, inside, regions + 1)
    sizes = np.bincount(pieces.reshape(-1))
    return np.where(sizes[pieces] >= min_pixels, pieces, 0).astype(np.int32)


def _fill(where: Bool) -> float:
    """Return how much of its tightest rotated rectangle ``where`` fills, 0..1."""
    v, u = np.nonzero(where)
    _, (width, height), _ = cv2.minAreaRect(np.stack([u, v], axis=1).astype(np.float32))
    return float(len(u) / ((width + 1) * (height + 1)))


def _number(things: Int32, where: Bool, ids: Array) -> None:
    """Give every distinct id under ``where`` a new number in ``things``; 0 stays nothing."""
    chosen = where if ids.min() > 0 else where & (ids > 0) if things.any() else where
    _, number = np.unique(ids[chosen], return_inverse=True)
    things[chosen] = number + 1 + things.max()
