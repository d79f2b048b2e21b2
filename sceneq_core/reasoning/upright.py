"""Boxes that stand upright, so that "on" and "left of" become comparisons of intervals."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.reasoning.reasoner import Candidate


@dataclass(frozen=True, slots=True)
class UprightBox:
    """An axis-aligned box in an upright frame: corners ``low`` and ``high`` (3,), metres.

    The frame's third axis is up.
    """

    low: Float64
    high: Float64

    @property
    def centre(self) -> Float64:
        """Middle of the box (3,)."""
        middle: Float64 = (self.low + self.high) / 2
        return middle

    @property
    def size(self) -> Float64:
        """Edge lengths (3,)."""
        return self.high - self.low


def upright_axes(T_world_box: Float64, up_world: Float64) -> Float64:
    """Return rows (3, 3): two level axes along a box's own sides, and up.

    Along the box, because a table that stands diagonally in the room then still has a tight
    footprint.
    """
    up = up_world / np.linalg.norm(up_world)
    box_axes = T_world_box[:3, :3].T
    level = box_axes[np.argmin(np.abs(box_axes @ up))]
    first = level - (level @ up) * up
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(up, first), up])


def upright_box(candidate: Candidate, axes: Float64) -> UprightBox:
    """Return the extent of a candidate's oriented box along ``axes`` (3, 3 rows)."""
    centre = axes @ candidate.T_world_box[:3, 3]
    half = np.abs(axes @ candidate.T_world_box[:3, :3]) @ (candidate.box_size_m / 2)
    return UprightBox(centre - half, centre + half)


def point_box(point_world: Float64, axes: Float64) -> UprightBox:
    """Return a point as a box without size."""
    point = axes @ point_world
    return UprightBox(point, point)


def separation(a: UprightBox, b: UprightBox) -> Float64:
    """Return the gaps (3,) between two boxes along the axes, 0 where they overlap, metres."""
    gaps: Float64 = np.maximum(0.0, np.maximum(a.low - b.high, b.low - a.high))
    return gaps


def distance(a: UprightBox, b: UprightBox) -> float:
    """Return the shortest distance between two boxes, metres."""
    return float(np.linalg.norm(separation(a, b)))


def overlap(a: UprightBox, b: UprightBox, axes: slice, thinnest_m: float) -> float:
    """Return the share of ``a`` in ``b`` along ``axes``, in [0, 1].

    An edge shorter than ``thinnest_m`` (a picture's depth) counts as that long, so that noise in
    a flat thing does not decide.
    """
    low = np.minimum(a.low, a.centre - thinnest_m / 2)[axes]
    high = np.maximum(a.high, a.centre + thinnest_m / 2)[axes]
    common = np.minimum(high, b.high[axes]) - np.maximum(low, b.low[axes])
    return float(np.prod(np.clip(common / (high - low), 0.0, 1.0)))
