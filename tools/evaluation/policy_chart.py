"""Cost-accuracy curves as a picture: a panel for every reasoner, a line for every policy."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import UInt8
from sceneq_core.picture.lettering import BOLD, FAINT, INK, Colour, text_size, write
from sceneq_tools.evaluation.policy_curve import Curve
from sceneq_tools.evaluation.policy_replay import ADAPTIVE, ALWAYS, NEVER, THRESHOLDS, Replayed

SIDE, LEFT, TOP, GAP, BELOW = 430, 70, 92, 90, 150
TEXT, TITLE = 14, 18
GRID: Colour = (227, 229, 232)
GREY: Colour = (150, 154, 160)
BLUE: Colour = (47, 109, 179)
ORANGE: Colour = (200, 116, 42)
SAND: Colour = (226, 180, 132)
GREEN: Colour = (75, 138, 90)
STEP = 0.05
"""Of the accuracy axis, which shows what there is and not 0 to 1."""

LEGEND = (
    (BLUE, "adaptive, at budgets from 3 calls an hour to no limit"),
    (ORANGE, "thresholds, scaled; the paper's are marked"),
    (SAND, "thresholds, at the same budgets, first come first served"),
    (GREY, "asking at random: from never to always"),
    (GREEN, "perfect foresight: nobody is above this"),
)


@dataclass(frozen=True, slots=True)
class _Panel:
    """Where a curve is drawn: ``left`` pixel and the accuracies at its bottom and top."""

    left: int
    low: float
    high: float

    def at(self, cost: float, accuracy: float) -> tuple[int, int]:
        share = (accuracy - self.low) / (self.high - self.low)
        return round(self.left + cost * SIDE), round(TOP + (1.0 - share) * SIDE)


def chart(curves: Sequence[Curve]) -> UInt8:
    """Return a picture (H, W, 3) RGB of one panel a curve, with a legend below."""
    width = LEFT + len(curves) * (SIDE + GAP)
    image = np.full((TOP + SIDE + BELOW, width, 3), 255, np.uint8)
    low, high = _limits(curves)
    for number, curve in enumerate(curves):
        _draw(image, curve, _Panel(LEFT + number * (SIDE + GAP), low, high))
    for row, (colour, says) in enumerate(LEGEND):
        y = TOP + SIDE + 52 + row * 19
        cv2.line(image, (LEFT, y + 8), (LEFT + 26, y + 8), colour, 3, cv2.LINE_AA)
        write(image, says, (LEFT + 36, y), TEXT, INK)
    return image


def _limits(curves: Sequence[Curve]) -> tuple[float, float]:
    """Return round accuracies below and above all that is drawn."""
    seen = [one.accuracy for curve in curves for one in curve.points]
    seen += [curve.foresight(1.0) for curve in curves]
    low, high = np.floor(min(seen) / STEP) * STEP, np.ceil(max(seen) / STEP) * STEP
    return float(low), float(max(high, low + STEP))


def _draw(image: UInt8, curve: Curve, panel: _Panel) -> None:
    write(image, curve.reasoner, (panel.left, 22), TITLE, INK, BOLD)
    says = f"share of {curve.questions} answers that are right"
    write(image, says, (panel.left, 50), TEXT, FAINT)
    _draw_axes(image, panel)
    costs = np.linspace(0.0, 1.0, 101)
    _line(image, [panel.at(cost, curve.foresight(cost)) for cost in costs], GREEN, 1)
    ends = [curve.point(name) for name in (NEVER, ALWAYS)]
    _line(image, [panel.at(min(end.cost, 1.0), end.accuracy) for end in ends], GREY, 1)
    scaled, limited = _split(curve.points)
    adaptive = _of(curve, ADAPTIVE)
    for points, colour in (
        (ends[:1] + limited, SAND),
        (scaled, ORANGE),
        (ends[:1] + adaptive, BLUE),
    ):
        places = [panel.at(min(one.cost, 1.0), one.accuracy) for one in points]
        _line(image, places, colour, 2)
        for place in places:
            cv2.circle(image, place, 4, colour, -1, cv2.LINE_AA)
    paper = curve.point(THRESHOLDS, "x 1")
    cv2.circle(image, panel.at(min(paper.cost, 1.0), paper.accuracy), 8, ORANGE, 2, cv2.LINE_AA)
    for end, name in zip(ends, (NEVER, ALWAYS), strict=True):
        _mark(image, panel.at(min(end.cost, 1.0), end.accuracy), name)


def _draw_axes(image: UInt8, panel: _Panel) -> None:
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        top, bottom = panel.at(share, panel.high), panel.at(share, panel.low)
        cv2.line(image, top, bottom, GRID, 1)
        _centred(image, f"{share:g}", bottom[0], bottom[1] + 8)
    for level in np.arange(panel.low, panel.high + STEP / 2, STEP).tolist():
        start, end = panel.at(0.0, level), panel.at(1.0, level)
        cv2.line(image, start, end, GRID, 1)
        says = f"{100 * level:.0f} %"
        write(image, says, (start[0] - text_size(says, TEXT)[0] - 10, start[1] - 9), TEXT, FAINT)
    _centred(image, "calls of the reasoner a question", panel.left + SIDE // 2, TOP + SIDE + 28)


def _split(points: Iterable[Replayed]) -> tuple[list[Replayed], list[Replayed]]:
    """Return the thresholds by how strict they are, and those at a budget."""
    own = [one for one in points if one.contender.policy == THRESHOLDS]
    limited = [one for one in own if one.contender.budget.calls_per_hour is not None]
    return [one for one in own if one not in limited], limited


def _of(curve: Curve, policy: str) -> list[Replayed]:
    return [one for one in curve.points if one.contender.policy == policy]


def _line(image: UInt8, places: Sequence[tuple[int, int]], colour: Colour, width: int) -> None:
    cv2.polylines(image, [np.array(places, np.int32)], False, colour, width, cv2.LINE_AA)


def _mark(image: UInt8, place: tuple[int, int], name: str) -> None:
    cv2.circle(image, place, 4, INK, -1, cv2.LINE_AA)
    below = place[1] + 8 if place[1] < TOP + SIDE - 30 else place[1] - 24
    write(image, name, (place[0] - 14, below), TEXT, INK, halo=True)


def _centred(image: UInt8, says: str, x: int, y: int) -> None:
    write(image, says, (x - text_size(says, TEXT)[0] // 2, y), TEXT, FAINT)
