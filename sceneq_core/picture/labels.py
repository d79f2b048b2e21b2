"""Which captions a view has, and how they are drawn."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from sceneq_core.arrays import Int32, UInt8
from sceneq_core.picture.captions import Caption, Placed, Rect
from sceneq_core.picture.colours import mark_colours
from sceneq_core.picture.lettering import BOLD, FAINT, INK, PAPER, REGULAR, Colour, text_size, write
from sceneq_core.picture.scene import Mark, Thing

LEADER: Colour = (90, 94, 100)


@dataclass(frozen=True, slots=True)
class Style:
    """How a caption is written."""

    text: str
    frame: Colour | None
    fill: Colour
    ink: Colour
    weight: int
    arrow: bool


def captions(
    things: Sequence[Thing],
    marks: Sequence[Mark],
    anchors: Mapping[int, tuple[int, int]],
    ids: Int32,
    letter_px: int,
) -> list[tuple[Caption, Style]]:
    """Return what to place, in this order: the marked, the named by certainty, the numbers."""
    found: list[tuple[Caption, Style]] = []
    for mark, colour in zip(marks, mark_colours(len(marks)), strict=True):
        style = Style(mark.text, colour, colour, PAPER, BOLD, True)
        caption = _caption(mark.instance_id, style, anchors[mark.instance_id], letter_px)
        found.append((replace(caption, reach=2 * letter_px), style))
    ink = FAINT if marks else INK
    marked = {mark.instance_id for mark in marks}
    pixels = dict(zip(*np.unique(ids, return_counts=True), strict=True))
    for thing in sorted(
        things, key=lambda t: (-t.named, -t.p * t.named, -pixels.get(t.instance_id, 0))
    ):
        if thing.instance_id in marked or thing.instance_id not in anchors:
            continue
        style = Style(thing.text, LEADER if thing.named else None, PAPER, ink, REGULAR, False)
        caption = _caption(thing.instance_id, style, anchors[thing.instance_id], letter_px)
        on_it = _fits(ids, caption)
        if on_it or thing.named:
            found.append((replace(caption, on_it=on_it), style))
    return found


def _caption(key: int, style: Style, anchor: tuple[int, int], letter_px: int) -> Caption:
    width, height = text_size(style.text, letter_px, style.weight)
    pad = letter_px // 2 if style.frame else 1
    return Caption(key, (width + 2 * pad, height + pad), anchor)


def _fits(ids: Int32, caption: Caption) -> bool:
    """Tell whether the thing itself is large enough in the picture to be written on."""
    (x, y), (width, height) = caption.anchor, caption.size
    u = np.rint(x + np.array([-0.5, 0, 0.5]) * width).astype(np.int64)
    v = np.rint(y + np.array([-0.5, 0, 0.5]) * height).astype(np.int64)
    if u[0] < 0 or v[0] < 0 or u[2] >= ids.shape[1] or v[2] >= ids.shape[0]:
        return False
    return bool((ids[np.ix_(v, u)] == caption.key).all())


def draw_captions(
    image: UInt8, placed: Sequence[Placed], styles: Mapping[int, Style], letter_px: int
) -> None:
    """Draw all lines first, so that none runs over a text."""
    for one in placed:
        if one.leader is not None:
            _draw_leader(image, one, styles[one.caption.key])
    for one in placed:
        _draw_text(image, one.rect, styles[one.caption.key], letter_px)


def _draw_leader(image: UInt8, placed: Placed, style: Style) -> None:
    assert placed.leader is not None
    start = (round(placed.leader[0]), round(placed.leader[1]))
    end = (round(placed.caption.anchor[0]), round(placed.caption.anchor[1]))
    if style.arrow:
        length = max(1.0, float(np.hypot(end[0] - start[0], end[1] - start[1])))
        cv2.arrowedLine(image, start, end, PAPER, 6, cv2.LINE_AA, tipLength=min(0.5, 12 / length))
        cv2.arrowedLine(
            image, start, end, style.fill, 3, cv2.LINE_AA, tipLength=min(0.5, 12 / length)
        )
        return
    cv2.line(image, start, end, LEADER, 1, cv2.LINE_AA)
    cv2.circle(image, end, 3, PAPER, -1, cv2.LINE_AA)
    cv2.circle(image, end, 2, LEADER, -1, cv2.LINE_AA)


def _draw_text(image: UInt8, rect: Rect, style: Style, letter_px: int) -> None:
    pad = letter_px // 2 if style.frame else 1
    at = (rect.left + pad, rect.top + pad // 2)
    if style.frame is not None:
        corner = (rect.right - 1, rect.bottom - 1)
        cv2.rectangle(image, (rect.left, rect.top), corner, style.fill, -1)
        cv2.rectangle(image, (rect.left, rect.top), corner, style.frame, 1)
    write(image, style.text, at, letter_px, style.ink, style.weight, halo=style.frame is None)
