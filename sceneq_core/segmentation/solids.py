"""Things with a shape: pieces of surface that depth steps and concave creases set apart."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Int32
from sceneq_core.segmentation.plane import fitted_plane
from sceneq_core.segmentation.surface import Surface

_GROWTH_PX = 5
_CLEAR_NOISES = 4
_TOP = 0.9


@dataclass(frozen=True, slots=True)
class Solids:
    """Labels int32 (h, w), 0 = none, and ``planes`` int32 (h, w): the flat part of large ones."""

    labels: Int32
    planes: Int32


@dataclass(frozen=True, slots=True)
class Limits:
    """``noise`` in 1/m, ``height_m`` of a thing over its plane, least sizes in pixels."""

    noise: float
    height_m: float
    pixels: int
    plane_pixels: int


def solids_of(surface: Surface, limits: Limits) -> Solids:
    """Return the solids of ``surface``.

    A large solid that is mostly one plane (table top, wall, floor) loses what stands in front of
    that plane: a crease with a gap does not glue a mug to its table.
    """
    free = (surface.closeness > 0) & ~surface.steps & ~surface.creases
    labels = np.zeros(free.shape, np.int32)
    planes = np.zeros(free.shape, np.int32)
    queue = _pieces(free, limits.pixels)
    label = 0
    while queue:
        piece = queue.pop(0)
        label += 1
        if piece.sum() >= limits.plane_pixels:
            flat, standing = _parted(surface, piece, limits)
            queue.extend(standing)
            for thing in standing:
                piece = piece & ~thing
            planes[flat] = label
        labels[piece] = label
    grown = _grown(labels, surface.closeness, 6 * limits.noise)
    return Solids(grown, np.where(planes == grown, planes, 0).astype(np.int32))


def _parted(surface: Surface, piece: Bool, limits: Limits) -> tuple[Bool, list[Bool]]:
    """Return the flat part of ``piece`` and the things that stand in front of its plane.

    What is thin, such as a magazine, stays in the flat part, where colour draws a better outline
    than depth; the flat part is closed over small holes for the same reason.
    """
    fit = fitted_plane(surface, piece, limits.noise)
    if fit is None:
        return np.zeros(piece.shape, bool), []
    plane, inliers = fit
    residual = plane.residual(surface.closeness)
    front = piece & (residual > _CLEAR_NOISES * limits.noise)
    back = piece & (residual < -_CLEAR_NOISES * limits.noise)
    height_m = plane.height_m(surface.closeness, surface.K)
    raised = _pieces(_morphed(front, cv2.MORPH_OPEN, 3), limits.pixels)
    standing = [t for t in raised if np.quantile(height_m[t], _TOP) > limits.height_m]
    standing += _carriers(surface, back & (height_m < -limits.height_m), inliers, limits)
    flat = _morphed(inliers | front, cv2.MORPH_CLOSE, 7)
    for thing in standing:
        flat &= ~thing
    return flat, standing


def _carriers(surface: Surface, behind: Bool, face: Bool, limits: Limits) -> list[Bool]:
    """Return the pieces of ``behind`` from whose own plane the ``face`` stands out.

    Two faces of one thing lie behind each other's planes (table top and side); a chair back in
    front of the floor does not, although the floor is behind the chair's plane.
    """
    carriers = []
    for other in _pieces(_morphed(behind, cv2.MORPH_OPEN, 3), limits.plane_pixels):
        fit = fitted_plane(surface, other, limits.noise)
        if fit is None:
            continue
        height_m = fit[0].height_m(surface.closeness, surface.K)
        if np.median(height_m[face]) > limits.height_m:
            carriers.append(other)
    return carriers


def _pieces(where: Bool, min_pixels: int) -> list[Bool]:
    """Return the connected pieces of ``where``, the largest first (then the topmost)."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(where.astype(np.uint8), connectivity=4)
    areas = stats[1:, cv2.CC_STAT_AREA]
    order = np.argsort(-areas, kind="stable")
    return [labels == i + 1 for i in order if areas[i] >= min_pixels]


def _morphed(where: Bool, operation: int, side_px: int) -> Bool:
    kernel = np.ones((side_px, side_px), np.uint8)
    return np.asarray(cv2.morphologyEx(where.astype(np.uint8), operation, kernel) > 0)


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
