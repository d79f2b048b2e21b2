"""One view of a scene: splats, what is marked, and captions that do not overlap."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float64, Int32, Int64, UInt8
from sceneq_core.picture.captions import Rect, place
from sceneq_core.picture.colours import dimmed, instance_colours, mark_colours, quieted, tinted
from sceneq_core.picture.labels import captions, draw_captions
from sceneq_core.picture.lettering import PAPER, Colour
from sceneq_core.picture.projection import Viewpoint
from sceneq_core.picture.scene import Cloud, Mark, Thing
from sceneq_core.picture.splats import FINER, ids_seen, reduced, shaded, splat

LEAST_PIXELS = 40
HIDDEN = 0.45
"""How strongly a marked thing shows through what hides it."""


@dataclass(frozen=True, slots=True)
class Panel:
    """A drawn view and how many of the things in it have a caption."""

    image: UInt8
    captioned: int
    visible: int


def shell_points(instance_id: Int32, things: Sequence[Thing]) -> Bool:
    """Tell which points (N,) are of walls, floors or nothing in particular."""
    shells = [0, *(thing.instance_id for thing in things if thing.is_shell)]
    return np.isin(instance_id, shells)


def point_colours(cloud: Cloud, things: Sequence[Thing], marks: Sequence[Mark]) -> UInt8:
    """Return a colour for each point (N, 3); with ``marks`` everything else is faint."""
    colours = instance_colours(cloud.instance_id, cloud.rgb)
    colours = quieted(colours, shell_points(cloud.instance_id, things))
    if not marks:
        return colours
    colours = dimmed(colours)
    for mark, colour in zip(marks, mark_colours(len(marks)), strict=True):
        own = cloud.instance_id == mark.instance_id
        colours[own] = tinted(cloud.rgb[own], colour)
    return colours


def draw_panel(
    viewpoint: Viewpoint,
    cloud: Cloud,
    colours: UInt8,
    things: Sequence[Thing],
    marks: Sequence[Mark],
    taken: Sequence[Rect] = (),
    letter_px: int = 14,
) -> Panel:
    """Return the view with captions, none of them over one another or over ``taken``.

    Args:
        viewpoint: from where, and how large.
        cloud: what is drawn; cut away beforehand what hides too much.
        colours: (N, 3) for its points.
        things: what may be captioned.
        marks: what must stand out.
        taken: where something else will be drawn.
        letter_px: height of the letters.
    """
    points_world = cloud.points_world.astype(np.float64)
    fine = viewpoint.enlarged(FINER)
    seen = splat(fine, points_world, cloud.voxel_size_m)
    image = shaded(seen, colours, cloud.instance_id)
    ids = ids_seen(seen, cloud.instance_id)
    for mark, colour in zip(marks, mark_colours(len(marks)), strict=True):
        _show_through(image, fine, cloud, ids, mark, colour)
    image = reduced(image)
    ids = np.ascontiguousarray(ids[::FINER, ::FINER])
    for mark, colour in zip(marks, mark_colours(len(marks)), strict=True):
        draw_box(image, viewpoint, mark.corners_world, colour)
    anchors = _mark_anchors(viewpoint, marks) | _anchors(ids)
    wanted = captions(things, marks, anchors, ids, letter_px)
    placed = place([caption for caption, _ in wanted], viewpoint.size, taken)
    draw_captions(image, placed, {c.key: s for c, s in wanted}, letter_px)
    shown = {thing.instance_id for thing in things} & anchors.keys()
    return Panel(image, len({p.caption.key for p in placed} & shown), len(shown))


def draw_box(image: UInt8, viewpoint: Viewpoint, corners_world: Float64, colour: Colour) -> None:
    """Draw the twelve edges between corners (8, 3), whose index counts the sides in binary."""
    pixels, depth_m = viewpoint.project(corners_world)
    if (depth_m <= 0).any():
        return
    ends = np.rint(pixels * 16).astype(np.int64)
    edges = [(i, i | bit) for i in range(8) for bit in (1, 2, 4) if not i & bit]
    for width, shade in ((4, PAPER), (2, colour)):
        for a, b in edges:
            (x, y), (u, v) = ends[a].tolist(), ends[b].tolist()
            cv2.line(image, (x, y), (u, v), shade, width, cv2.LINE_AA, shift=4)


def _show_through(
    image: UInt8, fine: Viewpoint, cloud: Cloud, ids: Int32, mark: Mark, colour: Colour
) -> None:
    """Let a marked thing be seen, fainter, through what hides it."""
    own = cloud.instance_id == mark.instance_id
    if not own.any():
        return
    alone = splat(fine, cloud.points_world[own].astype(np.float64), cloud.voxel_size_m)
    hidden = (alone.point >= 0) & (ids != mark.instance_id)
    image[hidden] = ((1 - HIDDEN) * image[hidden] + HIDDEN * np.array(colour)).astype(np.uint8)


def _anchors(ids: Int32) -> dict[int, tuple[int, int]]:
    """Return for each instance seen the pixel that is farthest inside it."""
    anchors = {}
    flat = ids.ravel()
    order = np.argsort(flat, kind="stable")
    found, first, count = np.unique(flat[order], return_index=True, return_counts=True)
    for key, begin, size in zip(found.tolist(), first, count, strict=True):
        if key > 0 and size >= LEAST_PIXELS:
            v, u = np.divmod(order[begin : begin + size], ids.shape[1])
            anchors[key] = _innermost(v, u)
    return anchors


def _innermost(v: Int64, u: Int64) -> tuple[int, int]:
    mask = np.zeros((int(np.ptp(v)) + 3, int(np.ptp(u)) + 3), np.uint8)
    mask[v - v.min() + 1, u - u.min() + 1] = 1
    inside = cv2.distanceTransform(mask, cv2.DIST_L2, 3)
    y, x = np.unravel_index(int(np.argmax(inside)), mask.shape)
    return int(x + u.min() - 1), int(y + v.min() - 1)


def _mark_anchors(viewpoint: Viewpoint, marks: Sequence[Mark]) -> dict[int, tuple[int, int]]:
    """Return the middle of the box of each marked thing: it may be hidden."""
    anchors = {}
    limit = np.array(viewpoint.size) - 1
    for mark in marks:
        (middle,), _ = viewpoint.project(mark.corners_world.mean(axis=0)[None])
        x, y = np.clip(np.rint(middle), 0, limit).astype(int).tolist()
        anchors[mark.instance_id] = (x, y)
    return anchors
