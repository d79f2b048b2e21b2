"""Captions beside what they name: none over another, the first given are the first placed."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64

GAP_PX = 3
RINGS_PX = (14, 26, 42, 62, 86, 116, 150, 190, 240)
ANGLES = 24
LEADER_OVER_ANCHOR = 25.0
"""A leader over another thing's anchor costs as much as being that many pixels longer."""


@dataclass(frozen=True, slots=True)
class Rect:
    """A box of pixels: left, top inclusive, right, bottom exclusive."""

    left: int
    top: int
    right: int
    bottom: int


@dataclass(frozen=True, slots=True)
class Caption:
    """A text box of ``size`` (width, height) for the pixel ``anchor`` (x, y).

    ``on_it``: only the place right on the anchor will do, there is no line to it.
    ``reach``: the line is at least so long.
    """

    key: int
    size: tuple[int, int]
    anchor: tuple[float, float]
    on_it: bool = False
    reach: int = 0


@dataclass(frozen=True, slots=True)
class Placed:
    """Where a caption stands; ``leader`` is where its line to the anchor starts, if it has one."""

    caption: Caption
    rect: Rect
    leader: tuple[float, float] | None


def place(
    captions: Sequence[Caption], size: tuple[int, int], taken: Sequence[Rect] = ()
) -> list[Placed]:
    """Return the captions that found a place inside ``size`` (width, height), in their order.

    No two rectangles touch, none lies on one of ``taken``, no leader runs through a caption or
    across another leader. What does not fit is left out.
    """
    anchors = np.array([caption.anchor for caption in captions], np.float64).reshape(-1, 2)
    placed: list[Placed] = []
    for number, caption in enumerate(captions):
        others = np.delete(anchors, number, axis=0)
        best = _best(caption, _Board(size, placed, taken), others)
        if best is not None:
            placed.append(best)
    return placed


class _Board:
    """What is already there, as arrays."""

    def __init__(
        self, size: tuple[int, int], placed: Sequence[Placed], taken: Sequence[Rect]
    ) -> None:
        rects = [*taken, *(p.rect for p in placed)]
        self.size = size
        self.rects = _as_array(rects)
        leaders = [(*p.caption.anchor, *p.leader) for p in placed if p.leader is not None]
        self.leaders = np.array(leaders, np.float64).reshape(-1, 4)


def _best(caption: Caption, board: _Board, others: Float64) -> Placed | None:
    """Return the cheapest place: a short leader that stays clear of other things' anchors."""
    places = _on_it(caption) if caption.on_it else _around(caption)
    free = places[_is_free(places, board)]
    if caption.on_it:
        return Placed(caption, _rect(free[0]), None) if len(free) else None
    anchor = np.asarray(caption.anchor)
    start = np.clip(anchor, free[:, :2], free[:, 2:])
    clear = ~_crosses(anchor, start, board)
    free, start = free[clear], start[clear]
    if not len(free):
        return None
    length = np.linalg.norm(start - anchor, axis=1)
    cost = length + LEADER_OVER_ANCHOR * _anchors_hit(free, others)
    chosen = int(np.argmin(cost))
    x, y = start[chosen]
    return Placed(caption, _rect(free[chosen]), (float(x), float(y)))


def _on_it(caption: Caption) -> Float64:
    (width, height), (x, y) = caption.size, caption.anchor
    left, top = round(x - width / 2), round(y - height / 2)
    return np.array([[left, top, left + width, top + height]], np.float64)


def _around(caption: Caption) -> Float64:
    """Return rectangles (M, 4) on rings around the anchor, their nearest edges on the ring."""
    (width, height), (x, y) = caption.size, caption.anchor
    angle = np.linspace(0, 2 * np.pi, ANGLES, endpoint=False)
    ring = caption.reach + np.repeat(np.array(RINGS_PX, np.float64), ANGLES)
    c, s = np.tile(np.cos(angle), len(RINGS_PX)), np.tile(np.sin(angle), len(RINGS_PX))
    left = np.rint(x + c * (ring + width / 2) - width / 2)
    top = np.rint(y + s * (ring + height / 2) - height / 2)
    return np.stack([left, top, left + width, top + height], axis=1)


def _is_free(places: Float64, board: _Board) -> Bool:
    """Tell which rectangles (M, 4) are inside and touch no caption and no leader."""
    width, height = board.size
    inside = (places[:, :2] >= 0).all(axis=1) & (places[:, 2:] <= [width, height]).all(axis=1)
    touching = _overlap(places, board.rects).any(axis=1)
    under_leader = _run_through(board.leaders, places).any(axis=0)
    free: Bool = np.logical_and.reduce([inside, ~touching, ~under_leader])
    return free


def _overlap(a: Float64, b: Float64) -> Bool:
    """Tell which of (M, 4) come within ``GAP_PX`` of which of (K, 4), (M, K)."""
    a, b = a[:, None], b[None]
    apart: Bool = (
        (a[..., 0] >= b[..., 2] + GAP_PX)
        | (b[..., 0] >= a[..., 2] + GAP_PX)
        | (a[..., 1] >= b[..., 3] + GAP_PX)
        | (b[..., 1] >= a[..., 3] + GAP_PX)
    )
    return ~apart


def _run_through(lines: Float64, rects: Float64) -> Bool:
    """Tell which lines (L, 4) run through which rectangles (M, 4), (L, M) (Liang, Barsky 1984)."""
    start, along = lines[:, None, :2], (lines[:, 2:] - lines[:, :2])[:, None]
    along = np.where(along == 0, 1e-9, along)
    one, other = (rects[None, :, :2] - start) / along, (rects[None, :, 2:] - start) / along
    enters = np.maximum(np.minimum(one, other).max(axis=-1), 0)
    leaves = np.minimum(np.maximum(one, other).min(axis=-1), 1)
    through: Bool = enters < leaves
    return through


def _crosses(anchor: Float64, start: Float64, board: _Board) -> Bool:
    """Tell which leaders from ``anchor`` to ``start`` (M, 2) cross a caption or another leader."""
    lines = np.hstack([np.broadcast_to(anchor, start.shape), start])
    crossing = _intersect(lines, board.leaders).any(axis=1)
    blocked: Bool = np.logical_or(crossing, _run_through(lines, board.rects).any(axis=1))
    return blocked


def _intersect(a: Float64, b: Float64) -> Bool:
    """Tell which of the segments (M, 4) cross which of (K, 4), (M, K)."""

    def side(line: Float64, x: Float64, y: Float64) -> Float64:
        dx, dy = line[..., 2] - line[..., 0], line[..., 3] - line[..., 1]
        turn: Float64 = np.sign(dx * (y - line[..., 1]) - dy * (x - line[..., 0]))
        return turn

    a, b = a[:, None], b[None]
    split_b = side(a, b[..., 0], b[..., 1]) * side(a, b[..., 2], b[..., 3]) < 0
    split_a = side(b, a[..., 0], a[..., 1]) * side(b, a[..., 2], a[..., 3]) < 0
    both: Bool = split_a & split_b
    return both


def _anchors_hit(rects: Float64, anchors: Float64) -> Float64:
    """Return how many anchors (K, 2) each rectangle (M, 4) would hide."""
    points = anchors[None]
    inside = (points >= rects[:, None, :2]) & (points <= rects[:, None, 2:])
    hidden: Float64 = inside.all(axis=-1).sum(axis=1).astype(np.float64)
    return hidden


def _as_array(rects: Sequence[Rect]) -> Float64:
    rows = [(r.left, r.top, r.right, r.bottom) for r in rects]
    return np.array(rows, np.float64).reshape(-1, 4)


def _rect(row: Float64) -> Rect:
    left, top, right, bottom = (int(x) for x in row)
    return Rect(left, top, right, bottom)
