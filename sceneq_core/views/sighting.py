"""How much of each instance a keyframe shows, and the view that comes of it."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Array, Bool, Int32
from sceneq_core.views.keyframe import Keyframe
from sceneq_core.views.place import STRIDE_PX
from sceneq_core.views.view import View

PX_PER_SAMPLE = STRIDE_PX * STRIDE_PX
MIN_PART = 0.2
"""A part of a mask smaller than this share of the largest part is taken for stray pixels."""


@dataclass(frozen=True, slots=True)
class Sighting:
    """One instance in one keyframe: full-resolution pixels, and whether the border cuts it."""

    visible_px: int
    cut: bool


def find_sightings(keyframe: Keyframe, instance_of_place: Int32) -> dict[int, Sighting]:
    """Return every instance that ``keyframe`` shows, by instance id."""
    samples = np.bincount(instance_of_place[keyframe.place].ravel())
    cut = np.zeros(len(samples), np.bool_)
    cut[instance_of_place[keyframe.edge_place]] = True
    shown = np.flatnonzero(samples[1:]) + 1
    visible_px = samples[shown] * PX_PER_SAMPLE
    return {
        instance_id: Sighting(px, is_cut)
        for instance_id, px, is_cut in zip(
            shown.tolist(), visible_px.tolist(), cut[shown].tolist(), strict=True
        )
    }


def make_view(keyframe: Keyframe, instance_image: Int32, instance_id: int) -> View:
    """Return the view of an instance that ``instance_image`` (H/2, W/2) shows, without strays."""
    mask, top, left = _cropped(instance_image == instance_id)
    others = instance_image[top : top + mask.shape[0], left : left + mask.shape[1]] > 0
    mask, down, right = _cropped(_without_strays(mask | _filled(mask) & ~others))
    top, left = top + down, left + right
    height, width = keyframe.size
    x1 = min((left + mask.shape[1]) * STRIDE_PX, width)
    y1 = min((top + mask.shape[0]) * STRIDE_PX, height)
    return View(
        seq=keyframe.seq,
        stamp_ns=keyframe.stamp_ns,
        visible_px=int(mask.sum()) * PX_PER_SAMPLE,
        box_xyxy=np.array([left * STRIDE_PX, top * STRIDE_PX, x1, y1], np.float32),
        mask=mask,
    )


def _cropped(mask: Bool) -> tuple[Bool, int, int]:
    """Return a copy of the rows and columns that hold the mask, and the first of each."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    top, left = int(rows[0]), int(columns[0])
    return mask[top : rows[-1] + 1, left : columns[-1] + 1].copy(), top, left


def _filled(mask: Bool) -> Bool:
    """Return the mask with holes of a sample or two closed: depth noise leaves its voxel."""
    kernel = np.ones((3, 3), np.uint8)
    return cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_CLOSE, kernel).astype(np.bool_)


def _without_strays(mask: Bool) -> Bool:
    """Return the mask's largest connected part and those that are not small beside it."""
    _, part, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    area: Array = stats[:, cv2.CC_STAT_AREA].copy()
    area[0] = 0
    return np.asarray((area >= MIN_PART * area.max())[part] & mask)
