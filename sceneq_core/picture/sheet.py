"""A scene on one sheet: from above and from two opposite upper corners."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float64, UInt8
from sceneq_core.picture.annotations import (
    axes_place,
    draw_axes,
    draw_corners,
    draw_scale,
    scale_place,
)
from sceneq_core.picture.captions import Rect
from sceneq_core.picture.cutaway import below_ceiling, open_towards, without_specks
from sceneq_core.picture.lettering import BOLD, FAINT, INK, REGULAR, Colour, text_size, write
from sceneq_core.picture.panel import Panel, draw_panel, point_colours, shell_points
from sceneq_core.picture.projection import Viewpoint, from_above, from_corner, room_axes
from sceneq_core.picture.scene import Cloud, Mark, Thing
from sceneq_core.picture.splats import BACKGROUND

SIZE = (1600, 1000)
RULE: Colour = (222, 222, 218)
CORNERS = (("A", -135.0), ("B", 45.0))
"""Name and azimuth in degrees of the two corners the scene is seen from."""


@dataclass(frozen=True, slots=True)
class Heading:
    """What stands over the sheet: the scene, what it holds, and a question with its answer."""

    title: str
    facts: str
    question: str = ""


@dataclass(frozen=True, slots=True)
class _Layout:
    """Where things stand on a sheet; ``unit`` is a thousandth of its height."""

    unit: float
    top: Rect
    corners: tuple[Rect, Rect]

    @property
    def letter_px(self) -> int:
        return max(9, round(15 * self.unit))


def draw_sheet(
    cloud: Cloud,
    things: Sequence[Thing],
    marks: Sequence[Mark],
    heading: Heading,
    size: tuple[int, int] = SIZE,
) -> UInt8:
    """Return a picture (H, W, 3) of ``size`` (width, height) of the scene.

    Ceiling and near walls are cut away; with ``marks``, one an instance, only those are in full
    colour, with their box and an arrow. Captions never overlap; over each view stands how many
    found a place.

    Raises:
        ValueError: there is no point to draw, or the sheet is smaller than 400 x 250.
    """
    if not len(cloud.points_world):
        raise ValueError("the scene has no points to draw")
    if size[0] < 400 or size[1] < 250:
        raise ValueError(f"size: must be at least 400 x 250, got {size[0]} x {size[1]}")
    layout = _layout(size)
    sheet = np.full((size[1], size[0], 3), BACKGROUND, np.uint8)
    _write_heading(sheet, heading, layout)
    R_room_world = room_axes(cloud.points_world, cloud.up_world)
    scene = _Scene(cloud, things, marks, R_room_world)
    letter_px = layout.letter_px
    with ThreadPoolExecutor(len(CORNERS)) as pool:  # numpy and OpenCV share the cores
        drawn = [
            pool.submit(scene.corner, name, azimuth_deg, rect, letter_px)
            for rect, (name, azimuth_deg) in zip(layout.corners, CORNERS, strict=True)
        ]
        _put(sheet, layout.top, *scene.plan(layout.top, letter_px), letter_px)
        for rect, corner in zip(layout.corners, drawn, strict=True):
            _put(sheet, rect, *corner.result(), letter_px)
    return sheet


class _Scene:
    """What every view of the sheet is drawn from."""

    def __init__(
        self, cloud: Cloud, things: Sequence[Thing], marks: Sequence[Mark], R_room_world: Float64
    ) -> None:
        self._things, self._marks, self._R_room_world = things, marks, R_room_world
        self._cloud, self._colours = cloud, point_colours(cloud, things, marks)
        self._points_room = cloud.points_world.astype(np.float64) @ R_room_world.T
        marked = np.isin(cloud.instance_id, [mark.instance_id for mark in marks])
        self._is_shell = shell_points(cloud.instance_id, things) & ~marked
        self._open = below_ceiling(self._points_room, self._is_shell)
        self._open &= without_specks(self._points_room, cloud.instance_id == 0)
        self._open = _or_all(self._open)

    def plan(self, rect: Rect, letter_px: int) -> tuple[Panel, str]:
        """Return the view from above and what it is called."""
        size = _size(rect, letter_px)
        viewpoint = from_above(self._kept_points(self._open), self._R_room_world, size)
        taken = [scale_place(size, letter_px), axes_place(size, letter_px)]
        panel = self._draw(viewpoint, self._open, taken, letter_px)
        draw_scale(panel.image, float(viewpoint.K[0, 0]), letter_px)
        draw_axes(panel.image, viewpoint, letter_px)
        draw_corners(panel.image, CORNERS, letter_px)
        return panel, "from above"

    def corner(
        self, name: str, azimuth_deg: float, rect: Rect, letter_px: int
    ) -> tuple[Panel, str]:
        """Return the view from a corner and what it is called."""
        open_here = open_towards(self._points_room, self._is_shell, azimuth_deg)
        kept = _or_all(self._open & open_here)
        size = _size(rect, letter_px)
        points = self._kept_points(kept)
        viewpoint = from_corner(points, self._R_room_world, azimuth_deg, size)
        taken = [axes_place(size, letter_px)]
        panel = self._draw(viewpoint, kept, taken, letter_px)
        draw_axes(panel.image, viewpoint, letter_px)
        return panel, f"from corner {name}"

    def _kept_points(self, kept: Bool) -> Float64:
        points: Float64 = self._cloud.points_world[kept].astype(np.float64)
        return points

    def _draw(
        self, viewpoint: Viewpoint, kept: Bool, taken: Sequence[Rect], letter_px: int
    ) -> Panel:
        cloud = replace(
            self._cloud,
            points_world=self._cloud.points_world[kept],
            rgb=self._cloud.rgb[kept],
            instance_id=self._cloud.instance_id[kept],
        )
        colours = self._colours[kept]
        return draw_panel(viewpoint, cloud, colours, self._things, self._marks, taken, letter_px)


def _or_all(kept: Bool) -> Bool:
    """Return ``kept``; all points of a map that would else have none left, such as a wall alone."""
    return kept if kept.any() else np.ones_like(kept)


def _layout(size: tuple[int, int]) -> _Layout:
    width, height = size
    unit = height / 1000
    gap, head = round(14 * unit), round(78 * unit)
    middle = round(0.54 * width)
    half = (height - head - 2 * gap) // 2
    right = (middle + gap, width - gap)
    return _Layout(
        unit,
        Rect(gap, head, middle, height - gap),
        (
            Rect(right[0], head, right[1], head + half),
            Rect(right[0], height - gap - half, right[1], height - gap),
        ),
    )


def _size(rect: Rect, letter_px: int) -> tuple[int, int]:
    """Return the size of the view in a frame: there is a line of text over it."""
    return rect.right - rect.left, rect.bottom - rect.top - 2 * letter_px


def _put(sheet: UInt8, rect: Rect, panel: Panel, name: str, letter_px: int) -> None:
    sheet[rect.top + 2 * letter_px : rect.bottom, rect.left : rect.right] = panel.image
    corner = (rect.right - 1, rect.bottom - 1)
    cv2.rectangle(sheet, (rect.left, rect.top), corner, RULE, 1)
    y, pad = rect.top + letter_px // 2, letter_px // 2
    write(sheet, name, (rect.left + pad, y), letter_px, INK, BOLD)
    note = f"{panel.captioned} of {panel.visible} visible instances captioned"
    width, _ = text_size(note, letter_px - 2)
    write(sheet, note, (rect.right - width - pad, y), letter_px - 2, FAINT)


def _write_heading(sheet: UInt8, heading: Heading, layout: _Layout) -> None:
    left, unit = layout.top.left, layout.unit
    title_px, px = max(12, round(28 * unit)), max(9, round(16 * unit))
    write(sheet, heading.title, (left, round(14 * unit)), title_px, INK, BOLD)
    write(sheet, heading.facts, (left, round(50 * unit)), px, FAINT, REGULAR)
    if heading.question:
        width, _ = text_size(heading.question, round(20 * unit), BOLD)
        at = (layout.corners[0].right - width, round(20 * unit))
        write(sheet, heading.question, at, round(20 * unit), INK, BOLD)
