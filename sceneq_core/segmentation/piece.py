"""A connected part of an image, kept in the window round it: most are far smaller than it."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Bool

MARGIN_PX = 4
"""What a window has round the piece: morphology of kernels up to 7 pixels never feels its edge."""


@dataclass(frozen=True, slots=True)
class Piece:
    """``mask`` bool (rows, columns), the part of ``window`` (a slice of each) that is the piece."""

    window: tuple[slice, slice]
    mask: Bool

    @property
    def pixels(self) -> int:
        """Return the area in pixels."""
        return int(np.count_nonzero(self.mask))

    def drawn(self, shape: tuple[int, ...]) -> Bool:
        """Return the piece in an image of ``shape``."""
        image = np.zeros(shape, bool)
        image[self.window] = self.mask
        return image

    def moved(self, origin: tuple[slice, slice]) -> "Piece":
        """Return the piece of an image that this one of its window ``origin`` is."""
        rows, columns = (
            slice(outer.start + inner.start, outer.start + inner.stop)
            for outer, inner in zip(origin, self.window, strict=True)
        )
        return Piece((rows, columns), self.mask)


def pieces_of(where: Bool, min_pixels: int) -> list[Piece]:
    """Return the connected pieces of ``where``, the largest first (then the topmost)."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(where.astype(np.uint8), connectivity=4)
    areas = stats[1:, cv2.CC_STAT_AREA]
    order = np.argsort(-areas, kind="stable")
    windows = {i + 1: _window(*stats[i + 1, :4].tolist()) for i in order if areas[i] >= min_pixels}
    return [Piece(window, labels[window] == label) for label, window in windows.items()]


def window_of(where: Bool) -> tuple[slice, slice]:
    """Return the window round ``where``."""
    return _window(*cv2.boundingRect(where.astype(np.uint8)))


def _window(left: int, top: int, width: int, height: int) -> tuple[slice, slice]:
    margin = MARGIN_PX
    rows = slice(max(top - margin, 0), top + height + margin)
    return rows, slice(max(left - margin, 0), left + width + margin)
