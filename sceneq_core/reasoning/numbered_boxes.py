"""Candidates as numbered boxes over few full views.

Full views, because a crop shows neither what stands around a thing nor how large it is; marks in
the picture, because models follow them better than coordinates alone (Yang et al., Set-of-Mark
Prompting, arXiv 2310.11441). Coordinates go along in the text for models that were taught them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import UInt8
from sceneq_core.picture.lettering import BOLD, text_size, write
from sceneq_core.reasoning.reasoner import Box, Views

Pixels = tuple[int, int, int, int]

# Okabe and Ito's colours without black and yellow: apart for the colour-blind, dark under white.
_COLOURS = ((213, 94, 0), (0, 114, 178), (0, 158, 115), (204, 60, 140), (90, 60, 180), (150, 90, 0))
_RIM = (255, 255, 255)


@dataclass(frozen=True, slots=True, eq=False)
class MarkedPicture:
    """``rgb`` uint8 (H, W, 3) with the ``boxes`` (xyxy in its pixels) of numbers drawn on it."""

    rgb: UInt8
    boxes: Mapping[int, Pixels]


def covering_views(views: Sequence[Views], most: int) -> tuple[int, ...]:
    """Return at most ``most`` keyframe seqs that together show as many things as possible.

    ``views`` holds those of every thing, most probable thing and most visible view first. Greedy:
    the keyframe with most things not shown yet, the most probable of them and the best seen first
    (Chvatal 1979: at most 1 + ln N times as many as needed).
    """
    shown_by: dict[int, dict[int, int]] = {}
    for thing, of_thing in enumerate(views):
        for rank, (seq, _) in enumerate(of_thing):
            shown_by.setdefault(seq, {}).setdefault(thing, rank)
    chosen: list[int] = []
    open_things = {thing for things in shown_by.values() for thing in things}
    while open_things and len(chosen) < most:
        seq = min(shown_by, key=lambda seq: _cost(seq, shown_by[seq], open_things))
        chosen.append(seq)
        open_things -= shown_by[seq].keys()
    return tuple(chosen)


def _cost(seq: int, things: Mapping[int, int], wanted: set[int]) -> tuple[int, list[int], int, int]:
    new = sorted(wanted & things.keys())
    return -len(new), new, sum(things[thing] for thing in new), seq


def draw_boxes(rgb: UInt8, boxes: Mapping[int, Box], longest_px: int) -> MarkedPicture:
    """Return a copy of a keyframe, its longer side at most ``longest_px``, with numbered boxes.

    Boxes are cut to the picture; one that lies outside of it is left out.
    """
    scale = _scale(rgb, longest_px)
    picture = _scaled(rgb, scale)
    placed = {
        number: pixels
        for number, box in sorted(boxes.items())
        if (pixels := _in_pixels(box, scale, picture.shape)) is not None
    }
    for number, pixels in placed.items():
        _outline(picture, pixels, _colour(number))
    tags: list[Pixels] = []
    for number, pixels in placed.items():
        tags.append(_tag(picture, str(number), pixels, tags))
    return MarkedPicture(picture, placed)


def is_visible(box: Box, rgb: UInt8, longest_px: int) -> bool:
    """Return whether any of ``box`` is left when ``rgb`` is drawn on by ``draw_boxes``."""
    scale = _scale(rgb, longest_px)
    shape = tuple(max(1, round(side * scale)) for side in rgb.shape[:2])
    return _in_pixels(box, scale, shape) is not None


def _scale(rgb: UInt8, longest_px: int) -> float:
    return min(1.0, longest_px / float(max(rgb.shape[:2])))


def _scaled(rgb: UInt8, scale: float) -> UInt8:
    if scale == 1.0:
        return rgb.copy()
    size = (max(1, round(rgb.shape[1] * scale)), max(1, round(rgb.shape[0] * scale)))
    return np.asarray(cv2.resize(rgb, size, interpolation=cv2.INTER_AREA), np.uint8)


def _in_pixels(box: Box, scale: float, shape: tuple[int, ...]) -> Pixels | None:
    limit = np.array([shape[1], shape[0]] * 2)
    x0, y0, x1, y1 = np.clip(np.array(box) * scale, 0, limit).round().astype(int).tolist()
    return (x0, y0, x1, y1) if x1 - x0 >= 1 and y1 - y0 >= 1 else None


def _outline(picture: UInt8, box: Pixels, colour: tuple[int, int, int]) -> None:
    """A coloured line with a white rim is seen on any ground."""
    x0, y0, x1, y1 = box
    line = _line_px(picture)
    cv2.rectangle(picture, (x0, y0), (x1 - 1, y1 - 1), _RIM, line + 2)
    cv2.rectangle(picture, (x0, y0), (x1 - 1, y1 - 1), colour, line)


def _tag(picture: UInt8, text: str, box: Pixels, taken: Sequence[Pixels]) -> Pixels:
    """Write the number on its colour, at the first corner of the box without another number."""
    size = max(14, round(max(picture.shape[:2]) / 36))
    pad = size // 4
    width, height = text_size(text, size, BOLD)[0] + 2 * pad, size + pad
    corners = [_inside(at, width, height, picture) for at in _corners(box, width, height)]
    place = next((c for c in corners if not any(_overlap(c, t) for t in taken)), corners[0])
    cv2.rectangle(picture, place[:2], place[2:], _colour(int(text)), cv2.FILLED)
    write(picture, text, (place[0] + pad, place[1] + pad // 2), size, _RIM, BOLD)
    return place


def _corners(box: Pixels, width: int, height: int) -> list[tuple[int, int]]:
    """Above the box first: there a number hides nothing of the thing."""
    x0, y0, x1, y1 = box
    outside = [(x0, y0 - height), (x1 - width, y0 - height), (x0, y1), (x1 - width, y1)]
    return [*outside, (x0, y0), (x1 - width, y0), (x0, y1 - height), (x1 - width, y1 - height)]


def _inside(at: tuple[int, int], width: int, height: int, picture: UInt8) -> Pixels:
    x = min(max(at[0], 0), max(picture.shape[1] - width, 0))
    y = min(max(at[1], 0), max(picture.shape[0] - height, 0))
    return (x, y, x + width, y + height)


def _overlap(a: Pixels, b: Pixels) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _line_px(picture: UInt8) -> int:
    return max(2, round(float(max(picture.shape[:2])) / 320))


def _colour(number: int) -> tuple[int, int, int]:
    return _COLOURS[(number - 1) % len(_COLOURS)]
