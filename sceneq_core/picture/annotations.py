"""What a plan needs to be read: a scale, the axes, and from where the other views look."""

from collections.abc import Sequence

import cv2
import numpy as np

from sceneq_core.arrays import Float64, UInt8
from sceneq_core.picture.captions import Rect
from sceneq_core.picture.lettering import BOLD, FAINT, INK, PAPER, Colour, write
from sceneq_core.picture.projection import Viewpoint

AXES: tuple[tuple[str, Colour], ...] = (
    ("x", (200, 40, 40)),
    ("y", (30, 140, 40)),
    ("z", (40, 70, 200)),
)
LEVEL = 0.3
"""Axes closer to the line of sight than this are left out: one would see a dot."""


def draw_scale(image: UInt8, pixels_per_metre: float, letter_px: int) -> None:
    """Draw a bar of 1, 2 or 5 times a power of ten metres, as long as fits into a quarter."""
    longest_m = 0.25 * image.shape[1] / pixels_per_metre
    power = 10.0 ** np.floor(np.log10(longest_m))
    length_m = max(step * power for step in (1, 2, 5) if step * power <= longest_m)
    left, y = letter_px, image.shape[0] - letter_px
    right = left + round(length_m * pixels_per_metre)
    cv2.line(image, (left, y), (right, y), INK, 2, cv2.LINE_AA)
    for x in (left, right):
        cv2.line(image, (x, y - letter_px // 3), (x, y + letter_px // 3), INK, 2, cv2.LINE_AA)
    write(
        image, f"{length_m:g} m", (left + 4, y - round(1.4 * letter_px)), letter_px, INK, halo=True
    )


def draw_axes(image: UInt8, viewpoint: Viewpoint, letter_px: int) -> None:
    """Draw the world's axes as they lie in this view."""
    height, width = image.shape[:2]
    place = axes_place((width, height), letter_px)
    origin = np.array([place.left + place.right, place.top + place.bottom]) / 2
    in_view = viewpoint.T_camera_world[:2, :3]
    for (name, colour), along in zip(AXES, in_view.T, strict=True):
        if np.linalg.norm(along) < LEVEL:
            continue
        end = origin + 2.4 * letter_px * along
        a, b = (_pixel(p) for p in (origin, end))
        cv2.arrowedLine(image, a, b, colour, 2, cv2.LINE_AA, tipLength=0.22)
        label = end + 0.8 * letter_px * along / np.linalg.norm(along)
        at = _pixel(label - [0.3 * letter_px, 0.5 * letter_px])
        write(image, name, at, letter_px, colour, BOLD, halo=True)


def axes_place(size: tuple[int, int], letter_px: int) -> Rect:
    """Return where the axes are drawn in a view of ``size`` (width, height)."""
    side = round(7.5 * letter_px)
    return Rect(size[0] - side, size[1] - side, size[0], size[1])


def scale_place(size: tuple[int, int], letter_px: int) -> Rect:
    """Return where the scale is drawn in a view of ``size`` (width, height)."""
    return Rect(0, size[1] - 3 * letter_px, size[0] // 3, size[1])


def draw_corners(image: UInt8, corners: Sequence[tuple[str, float]], letter_px: int) -> None:
    """Draw on the plan from where the other two views look."""
    height, width = image.shape[:2]
    for name, azimuth_deg in corners:
        c, s = np.cos(np.radians(azimuth_deg)), -np.sin(np.radians(azimuth_deg))
        place = corner_place((width, height), (c, s), letter_px)
        middle = np.array([place.left + place.right, place.top + place.bottom]) / 2
        inwards = -np.array([np.sign(c), np.sign(s)]) / np.sqrt(2)
        a, b = (
            _pixel(middle + 0.8 * letter_px * inwards),
            _pixel(middle + 2.2 * letter_px * inwards),
        )
        cv2.circle(image, _pixel(middle), round(0.8 * letter_px), FAINT, -1, cv2.LINE_AA)
        cv2.arrowedLine(image, a, b, FAINT, 2, cv2.LINE_AA, tipLength=0.4)
        write(
            image,
            name,
            _pixel(middle - [0.32 * letter_px, 0.5 * letter_px]),
            letter_px,
            PAPER,
            BOLD,
        )


def corner_place(size: tuple[int, int], side: tuple[float, float], letter_px: int) -> Rect:
    """Return a square in the corner of the plan on that ``side``, above the scale bar."""
    edge = 2 * letter_px
    left = letter_px // 2 if side[0] < 0 else size[0] - edge - letter_px // 2
    top = letter_px // 2 if side[1] < 0 else size[1] - 3 * letter_px - edge
    return Rect(left, top, left + edge, top + edge)


def _pixel(point: Float64) -> tuple[int, int]:
    x, y = np.rint(point).astype(int).tolist()
    return x, y
