"""Things with a shape: pieces of surface that depth steps and concave creases set apart."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Int32
from sceneq_core.segmentation.plane import fitted_plane
from sceneq_core.segmentation.surface import Surface

_GROWTH_PX = 5
_IN_FRONT_NOISES = 4
_OPENING = np.ones((3, 3), np.uint8)
_SIDES = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.uint8)


@dataclass(frozen=True, slots=True)
class Solids:
    """Labels int32 (h, w), 0 = none, and ``planes`` int32 (h, w): the flat part of large ones."""

    labels: Int32
    planes: Int32


def solids_of(surface: Surface, noise: float, min_pixels: int, min_plane_pixels: int) -> Solids:
    """Return the solids of ``surface``.

    A large solid that is mostly one plane (table top, wall, floor) loses what stands in front of
    that plane: a crease with a gap does not glue a mug to its table.
    """
    free = (surface.closeness > 0) & ~surface.steps & ~surface.creases
    labels = np.zeros(free.shape, np.int32)
    planes = np.zeros(free.shape, np.int32)
    queue = _pieces(free, min_pixels)
    count = 0
    while queue:
        piece = queue.pop(0)
        count += 1
        if piece.sum() >= min_plane_pixels:
            fit = fitted_plane(surface.closeness, piece, noise)
            if fit is not None:
                plane, inliers = fit
                front = piece & (plane.residual(surface.closeness) > _IN_FRONT_NOISES * noise)
                standing = _pieces(_opened(front), min_pixels)
                for other in standing:
                    piece = piece & ~other
                queue.extend(standing)
                planes[inliers & piece] = count
        labels[piece] = count
    return Solids(_grown(labels, surface.closeness, 6 * noise), planes)


def _pieces(where: Bool, min_pixels: int) -> list[Bool]:
    """Return the connected pieces of ``where``, the largest first (then the topmost)."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(where.astype(np.uint8), connectivity=4)
    areas = stats[1:, cv2.CC_STAT_AREA]
    order = np.argsort(-areas, kind="stable")
    return [labels == i + 1 for i in order if areas[i] >= min_pixels]


def _opened(where: Bool) -> Bool:
    return np.asarray(cv2.morphologyEx(where.astype(np.uint8), cv2.MORPH_OPEN, _OPENING) > 0)


def _grown(labels: Int32, closeness: Float32, max_step: float) -> Int32:
    """Return labels spread over the unlabelled border where the surface goes on."""
    grown = labels.copy()
    for _ in range(_GROWTH_PX):
        source = grown.copy()
        for axis, shift in ((0, 1), (0, -1), (1, 1), (1, -1)):
            near, near_closeness = (_shifted(a, axis, shift) for a in (source, closeness))
            close = np.abs(near_closeness - closeness) < max_step
            take = (grown == 0) & (near > 0) & close & (closeness > 0)
            grown[take] = near[take]
    return grown


def _shifted(values: Int32 | Float32, axis: int, shift: int) -> Int32 | Float32:
    """Return ``values`` moved by one pixel, the border repeated."""
    rolled = np.roll(values, shift, axis)
    edge = 0 if shift > 0 else -1
    index = (edge, slice(None)) if axis == 0 else (slice(None), edge)
    rolled[index] = values[index]
    return rolled
