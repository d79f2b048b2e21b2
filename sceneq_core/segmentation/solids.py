"""Things with a shape: pieces of surface that depth steps and concave creases set apart."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Int32
from sceneq_core.segmentation.piece import Piece, pieces_of
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
    queue = pieces_of(free, limits.pixels)
    label = 0
    while queue:
        piece = queue.pop(0)
        label += 1
        labels[piece.window][piece.mask] = label
        if piece.pixels >= limits.plane_pixels:
            flat, standing = _parted(surface.inside(piece.window), piece.mask, limits)
            planes[piece.window][flat] = label
            queue.extend(thing.moved(piece.window) for thing in standing)  # and get other labels
    grown = _grown(labels, surface.closeness, 6 * limits.noise)
    return Solids(grown, np.where(planes == grown, planes, 0).astype(np.int32))


def _parted(surface: Surface, where: Bool, limits: Limits) -> tuple[Bool, list[Piece]]:
    """Return the flat part of the piece ``where`` and the things in front of its plane.

    What is thin, such as a magazine, stays in the flat part, where colour draws a better outline
    than depth; the flat part is closed over small holes for the same reason.
    """
    fit = fitted_plane(surface, where, limits.noise)
    if fit is None:
        return np.zeros(where.shape, bool), []
    plane, inliers = fit
    residual = plane.residual(surface.closeness)
    front = where & (residual > _CLEAR_NOISES * limits.noise)
    back = where & (residual < -_CLEAR_NOISES * limits.noise)
    height_m = plane.height_m(surface.closeness, surface.K)
    raised = pieces_of(_morphed(front, cv2.MORPH_OPEN, 3), limits.pixels)
    standing = [t for t in raised if _top_m(height_m, t) > limits.height_m]
    standing += _carriers(surface, back & (height_m < -limits.height_m), inliers, limits)
    flat = _morphed(inliers | front, cv2.MORPH_CLOSE, 7)
    for thing in standing:
        flat[thing.window] &= ~thing.mask
    return flat, standing


def _top_m(height_m: Float32, thing: Piece) -> float:
    """Return the height of ``thing``, less what its edge may exaggerate."""
    return float(np.quantile(height_m[thing.window][thing.mask], _TOP))


def _carriers(surface: Surface, behind: Bool, face: Bool, limits: Limits) -> list[Piece]:
    """Return the pieces of ``behind`` from whose own plane the ``face`` stands out.

    Two faces of one thing lie behind each other's planes (table top and side); a chair back in
    front of the floor does not, although the floor is behind the chair's plane.
    """
    carriers = []
    for other in pieces_of(_morphed(behind, cv2.MORPH_OPEN, 3), limits.plane_pixels):
        fit = fitted_plane(surface, other.drawn(behind.shape), limits.noise)
        if fit is None:
            continue
        height_m = fit[0].height_m(surface.closeness, surface.K)
        if np.median(height_m[face]) > limits.height_m:
            carriers.append(other)
    return carriers


def _morphed(where: Bool, operation: int, side_px: int) -> Bool:
    kernel = np.ones((side_px, side_px), np.uint8)
    return np.asarray(cv2.morphologyEx(where.astype(np.uint8), operation, kernel) > 0)


def _grown(labels: Int32, closeness: Float32, max_step: float) -> Int32:
    """Return labels spread over the unlabelled border where the surface goes on.

    Works on the pixels still open, by their place in an image with an empty frame round it.
    """
    grown = np.pad(labels, 1).reshape(-1)
    surface = np.pad(closeness, 1).reshape(-1)
    width = labels.shape[1] + 2
    bare = np.flatnonzero((grown == 0) & (surface > 0))
    for _ in range(_GROWTH_PX):
        source = grown.copy()
        for shift in (-width, width, -1, 1):
            close = np.abs(surface[bare + shift] - surface[bare]) < max_step
            take = bare[close & (grown[bare] == 0)]
            grown[take] = source[take + shift]
        bare = bare[grown[bare] == 0]
    return grown.reshape(-1, width)[1:-1, 1:-1]
