"""Measurements as a picture: every ratio on one scale, and what grows with the recording."""

from collections.abc import Iterator
from itertools import pairwise

import cv2
import numpy as np

from sceneq_core.arrays import UInt8
from sceneq_core.picture.lettering import BOLD, FAINT, INK, REGULAR, Colour, text_size, write
from sceneq_tools.bench.measurement import Measurement
from sceneq_tools.bench.report import Results, figures

WIDTH, MARGIN = 1280, 28
ROW, TEXT, TITLE = 24, 14, 19
VALUE_RIGHT, RATIO_RIGHT, BAR_LEFT, BAR_RIGHT = 390, 476, 650, 1230
CURVE_HEIGHT = 220
GRID: Colour = (227, 229, 232)
BLUE: Colour = (47, 109, 179)
LEAST_DECADES = 1.0


def chart(results: Results) -> UInt8:
    """Return a picture (H, W, 3) RGB of everything that has a ratio or a series."""
    compared = {bench: [one for one in some if one.ratio] for bench, some in results.items()}
    compared = {bench: some for bench, some in compared.items() if some}
    grown = [one for some in results.values() for one in some if len(one.series) > 1]
    rows = sum(len(some) + 2 for some in compared.values())
    height = 2 * MARGIN + 3 * ROW + rows * ROW + len(grown) * (CURVE_HEIGHT + 3 * ROW)
    image = np.full((height, WIDTH, 3), 255, np.uint8)
    y = _draw_ratios(image, compared, MARGIN)
    for one in grown:
        y = _draw_series(image, one, y + ROW)
    return image


def _draw_ratios(image: UInt8, compared: Results, y: int) -> int:
    """Draw bars that start at 1x: as fast, or as big, as the reference; return where it ends."""
    write(image, "beside the reference of the same run", (MARGIN, y), TITLE, INK, BOLD)
    says = "1x = the reference; of times and sizes less is better, of rates more"
    write(image, says, (MARGIN, y + ROW), TEXT, FAINT)
    decades = _decades([one for some in compared.values() for one in some])
    top = y + 3 * ROW
    bottom = top + ROW * sum(len(some) + 2 for some in compared.values()) - ROW
    for power in range(-int(decades), int(decades) + 1):
        x = _x(float(power), decades)
        cv2.line(image, (x, top - 4), (x, bottom), INK if power == 0 else GRID, 1)
        _write_centred(image, f"{10.0**power:g}x", x, top - ROW)
    for (bench, some), first in zip(compared.items(), _tops(compared, top), strict=True):
        write(image, bench, (MARGIN, first), TEXT + 2, INK, BOLD)
        for row, one in enumerate(some, 1):
            _draw_bar(image, one, first + row * ROW, decades)
    return bottom


def _tops(compared: Results, top: int) -> Iterator[int]:
    for some in compared.values():
        yield top
        top += (len(some) + 2) * ROW


def _draw_bar(image: UInt8, one: Measurement, y: int, decades: float) -> None:
    assert one.ratio is not None  # only what has a ratio is drawn
    x0, x1 = _x(0.0, decades), _x(float(np.log10(one.ratio)), decades)
    cv2.rectangle(image, (min(x0, x1), y + 3), (max(x0, x1), y + 15), BLUE, -1)
    write(image, one.name, (MARGIN + 14, y), TEXT, INK)
    _write_right(image, f"{figures(one.value)} {one.unit}", VALUE_RIGHT, y, INK)
    _write_right(image, f"{figures(one.ratio)}x", RATIO_RIGHT, y, INK)
    _write_right(image, one.beside, BAR_LEFT - 16, y, FAINT, RATIO_RIGHT + 10)


def _draw_series(image: UInt8, one: Measurement, y: int) -> int:
    """Draw how a measurement came about, from 0; return where it ends."""
    most = max(one.series)
    says = f"{one.name.partition(',')[0]}: {one.unit}, keyframe by keyframe"
    write(image, says, (MARGIN, y), TEXT + 2, INK, BOLD)
    top, bottom, left = y + 2 * ROW, y + 2 * ROW + CURVE_HEIGHT - ROW, MARGIN + 70
    for share in (0.0, 0.5, 1.0):
        level = round(bottom + share * (top - bottom))
        cv2.line(image, (left, level), (BAR_RIGHT, level), GRID, 1)
        _write_right(image, figures(share * most), left - 8, level - 8, FAINT)
    xs = np.linspace(left, BAR_RIGHT, len(one.series)).round().astype(int)
    ys = (bottom - (bottom - top) * np.array(one.series) / (most or 1.0)).round().astype(int)
    for start, end in pairwise(zip(xs.tolist(), ys.tolist(), strict=True)):
        cv2.line(image, start, end, BLUE, 2, cv2.LINE_AA)
    for number, x in ((1, left), (len(one.series), BAR_RIGHT)):
        _write_centred(image, str(number), x, bottom + 6)
    return bottom + ROW


def _decades(measured: list[Measurement]) -> float:
    """Return how many powers of ten the scale has on either side of 1x."""
    logs = [abs(float(np.log10(one.ratio))) for one in measured if one.ratio]
    return float(np.ceil(max([LEAST_DECADES, *logs])))


def _x(log_ratio: float, decades: float) -> int:
    middle, half = (BAR_LEFT + BAR_RIGHT) / 2, (BAR_RIGHT - BAR_LEFT) / 2
    return round(middle + half * log_ratio / decades)


def _write_right(
    image: UInt8, text: str, right: int, y: int, colour: Colour, least: int = 0
) -> None:
    """Write so that the text ends at ``right``; what would start before ``least`` is cut."""
    while least and len(text) > 1 and right - text_size(text, TEXT, REGULAR)[0] < least:
        text = text[:-2] + "…"
    write(image, text, (right - text_size(text, TEXT, REGULAR)[0], y), TEXT, colour)


def _write_centred(image: UInt8, text: str, x: int, y: int) -> None:
    write(image, text, (x - text_size(text, TEXT, REGULAR)[0] // 2, y), TEXT, FAINT)
