"""Synthetic images with the statistics of photographs, to set the ranges of a quantised network.

Dead leaves: shapes of random size, place and colour that hide each other; with sizes that follow
r^-3 their edges and spectra are those of natural images (A. Lee, D. Mumford and J. Huang, IJCV
2001, doi 10.1023/A:1011109015675).
"""

import cv2
import numpy as np

from sceneq_core.arrays import UInt8

LEAVES = 700
SMALLEST_PX = 4.0


def dead_leaves(seed: int, side_px: int) -> UInt8:
    """Return an image (side, side, 3); the same for the same seed."""
    rng = np.random.default_rng(seed)
    image = np.full((side_px, side_px, 3), rng.integers(0, 256, 3), np.uint8)
    for _ in range(LEAVES):
        _draw_leaf(image, rng)
    return np.asarray(cv2.GaussianBlur(image, (0, 0), rng.uniform(0.5, 3.0)), np.uint8)


def _draw_leaf(image: UInt8, rng: np.random.Generator) -> None:
    side = image.shape[0]
    radius = min(side / 2, SMALLEST_PX / np.sqrt(max(rng.random(), 1e-3)))
    x, y = rng.integers(0, side, 2).tolist()
    colour = np.clip(rng.normal(120, 70) + rng.normal(0, 35, 3), 0, 255).astype(int).tolist()
    if rng.random() < 0.5:
        cv2.circle(image, (x, y), int(radius), colour, -1, cv2.LINE_AA)
        return
    edges = (2 * radius, radius * rng.uniform(0.4, 2.0))
    corners = cv2.boxPoints(((x, y), edges, rng.uniform(0, 180)))
    cv2.fillConvexPoly(image, corners.astype(np.int32), colour, cv2.LINE_AA)
