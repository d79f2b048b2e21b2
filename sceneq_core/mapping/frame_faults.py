"""What is wrong with a frame by itself, before it is compared with anything."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Array, Bool
from sceneq_core.checks import need_between, need_within
from sceneq_core.frame import Frame

_SAMPLES = 160
"""Pixels along the longer side that are looked at: a torn image shows at any resolution."""


@dataclass(frozen=True, slots=True)
class FaultParams:
    """When the images of a frame count as broken.

    Less than ``min_depth_share`` of the pixels with a depth is nearly none. A pixel is black up to
    ``black_level`` (of 255; compression leaves a little). An image is cut when a band from one of
    its sides, ``min_cut_share`` of it or more, is blank and ends along a whole row or column:
    scenes do not end so straight.
    """

    min_depth_share: float = 0.02
    black_level: int = 8
    min_cut_share: float = 0.3

    def __post_init__(self) -> None:
        need_between(self, 0, 1, "min_depth_share", "min_cut_share")
        need_within(self, 0, 254, "black_level")


def fault(frame: Frame, params: FaultParams) -> str:
    """Return why no map can use ``frame``, "kind" or "kind: details"; empty when it can."""
    if not np.isfinite(cv2.sumElems(frame.depth_m)[0]):
        return "depth not finite"
    if not _rigid(frame):
        return "pose not rigid"
    step = _step(frame)
    share = float((frame.depth_m[::step, ::step] > 0).mean())
    if share < params.min_depth_share:
        return f"hardly any depth: in {share:.1%} of the image"
    brightest = np.maximum.reduce(np.moveaxis(frame.rgb[::step, ::step], 2, 0))
    cut = _cut_share(brightest <= params.black_level)
    return f"colour black: {cut:.0%} of the image" if cut >= params.min_cut_share else ""


def depth_cut(frame: Frame, params: FaultParams) -> str:
    """Return how much of the depth image is missing along a straight line, empty when none.

    A level camera in a hall can look like this, when the floor leaves the range of the sensor.
    """
    step = _step(frame)
    cut = _cut_share(frame.depth_m[::step, ::step] <= 0)
    return f"depth cut off: {cut:.0%} of the image" if cut >= params.min_cut_share else ""


def _step(frame: Frame) -> int:
    height, width = frame.depth_m.shape
    return max(1, round(float(max(height, width)) / _SAMPLES))


def _rigid(frame: Frame) -> bool:
    rotation = frame.T_world_camera[:3, :3]
    near = np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-2)
    return bool(near and np.linalg.det(rotation) > 0)


def _cut_share(blank: Bool) -> float:
    """Return the share of the image in the largest blank band that ends in a straight edge."""
    rows, columns = blank.mean(axis=1), blank.mean(axis=0)
    return max(_band(side) for side in (rows, rows[::-1], columns, columns[::-1]))


def _band(blank: Array) -> float:
    """Return the share of leading lines that are blank, 0 when the next ones are blank in part."""
    filled = np.flatnonzero(blank < 0.98)
    if not len(filled):
        return 1.0
    edge = filled[0] + 1  # the first line may be a mixture of both sides
    return float(filled[0] / len(blank)) if blank[edge : edge + 3].mean() < 0.5 else 0.0
