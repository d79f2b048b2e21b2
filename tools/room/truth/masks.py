"""Segments as a 2D model would find them, from the exact instance image and chance.

Some things are missed, some fall into pieces, some run into their neighbour, edges are off by a
pixel or two; the numbers of the segments say nothing from one frame to the next.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Array, Bool, Float64, UInt8, UInt16
from sceneq_core.checks import need_at_least, need_within


@dataclass(frozen=True, slots=True)
class MaskParams:
    """How imperfect the masks are.

    Attributes:
        miss: probability that a segment is not found.
        split: probability that a large segment is cut by a line; ``again``: that a piece of it
            is cut once more.
        merge: probability that a segment runs into the neighbour with the longest common edge.
        shift_px: pixels, at 640x480, that its edge is drawn in, at most.
        split_share: share of the image from which a segment is large.
        least_share: share of the image below which a segment is not found at all.
    """

    miss: float = 0.04
    split: float = 0.25
    again: float = 0.35
    merge: float = 0.1
    shift_px: float = 2.0
    split_share: float = 5e-3
    least_share: float = 2.5e-4

    def __post_init__(self) -> None:
        need_within(self, 0.0, 1.0, "miss", "split", "again", "merge")
        need_at_least(self, 0.0, "shift_px", "split_share", "least_share")


def imperfect_masks(
    instance_id: UInt16, rng: np.random.Generator, params: MaskParams | None = None
) -> UInt16:
    """Return segments uint16 (H, W), 0 = none, that a segmenter might have found."""
    params = params or MaskParams()
    segments = _merged(instance_id, rng, params)
    found = np.zeros(instance_id.shape, np.uint16)
    pieces: list[Bool] = []
    for segment in np.unique(segments[segments > 0]):
        whole = segments == segment
        if rng.random() >= params.miss:
            pieces += _split(whole, rng, params)
    for number, piece in zip(1 + rng.permutation(len(pieces)), pieces, strict=True):
        shrunk = _shrunk(piece, rng, params)
        if shrunk.sum() >= params.least_share * shrunk.size:
            found[shrunk] = number
    return found


def _merged(instance_id: UInt16, rng: np.random.Generator, params: MaskParams) -> UInt16:
    """Give some segments the number of the neighbour that they share the longest edge with."""
    merged = instance_id.copy()
    border = _border_lengths(instance_id)
    for segment in np.unique(instance_id[instance_id > 0]):
        lengths = border.get(int(segment), {})
        if rng.random() < params.merge and lengths:
            neighbour = max(sorted(lengths), key=lambda other: lengths[other])
            merged[instance_id == segment] = neighbour
    return merged


def _border_lengths(instance_id: UInt16) -> dict[int, dict[int, int]]:
    """Return for every id the pixels of its edge with each other id."""
    lengths: dict[int, dict[int, int]] = {}
    sides = ((instance_id[:, 1:], instance_id[:, :-1]), (instance_id[1:], instance_id[:-1]))
    pairs = np.concatenate([_unequal(a, b) for a, b in sides])
    unique, count = np.unique(pairs, axis=0, return_counts=True)
    for (a, b), pixels in zip(unique.tolist(), count.tolist(), strict=True):
        for one, other in ((a, b), (b, a)):
            row = lengths.setdefault(one, {})
            row[other] = row.get(other, 0) + pixels
    return lengths


def _unequal(a: Array, b: Array) -> Array:
    differs = (a != b) & (a > 0) & (b > 0)
    return np.column_stack([a[differs], b[differs]]).astype(np.int64)


def _split(whole: Bool, rng: np.random.Generator, params: MaskParams) -> list[Bool]:
    if whole.sum() < params.split_share * whole.size or rng.random() >= params.split:
        return [whole]
    first, second = _cut(whole, rng)
    pieces = [first, *(_cut(second, rng) if rng.random() < params.again else (second,))]
    return [piece for piece in pieces if piece.any()]


def _cut(whole: Bool, rng: np.random.Generator) -> tuple[Bool, Bool]:
    """Cut along a straight line through a random pixel of it."""
    rows, columns = np.nonzero(whole)
    at = int(rng.integers(len(rows)))
    angle = float(rng.uniform(0, np.pi))
    side = np.zeros(whole.shape, np.bool_)
    side[rows, columns] = _left_of(rows - rows[at], columns - columns[at], angle)
    return side, whole & ~side


def _left_of(down: Array, right: Array, angle: float) -> Bool:
    offset: Float64 = down * np.cos(angle) - right * np.sin(angle)
    left: Bool = offset > 0
    return left


def _shrunk(piece: Bool, rng: np.random.Generator, params: MaskParams) -> Bool:
    """Draw the edge in by a chance number of pixels; what is thin stays as it is."""
    most = params.shift_px * piece.shape[0] / 480
    radius = int(rng.integers(0, int(np.floor(most + 0.5)) + 1))
    if radius == 0:
        return piece
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
    image: UInt8 = piece.astype(np.uint8)
    shrunk: Bool = cv2.erode(image, disc, borderType=cv2.BORDER_REPLICATE) > 0
    return shrunk if shrunk.sum() >= 0.5 * piece.sum() else piece
