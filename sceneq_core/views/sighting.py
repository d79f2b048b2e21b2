"""How much of each instance a keyframe shows, and the view that comes of it."""

from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Array, Bool, Int32, Int64
from sceneq_core.views.keyframe import Keyframe
from sceneq_core.views.place import STRIDE_PX
from sceneq_core.views.view import View

PX_PER_SAMPLE = STRIDE_PX * STRIDE_PX
MIN_PART = 0.2
"""A part of a mask smaller than this share of the largest part is taken for stray pixels."""


@dataclass(frozen=True, slots=True)
class Sightings:
    """What one keyframe shows of each instance, by instance id, in full-resolution pixels.

    ``visible_px`` how much there is; ``cut`` which reach the border of what the camera saw;
    ``moved_px`` how much came or went since a view was made of it.
    """

    visible_px: dict[int, int]
    cut: set[int]
    moved_px: dict[int, int]

    def update(self, keyframe: Keyframe, touched: Int32, before: Int32, now: Int32) -> set[int]:
        """Take over that the places of the ``touched`` pixels went from one instance to another.

        ``before`` and ``now`` are the instance of each place. Returns the instances concerned.
        """
        lost, gained = _count(before.take(touched)), _count(now.take(touched))
        for instance_id in lost.keys() | gained.keys():
            came, went = gained.get(instance_id, 0), lost.get(instance_id, 0)
            self.visible_px[instance_id] = self.visible_px.get(instance_id, 0) + came - went
            self.moved_px[instance_id] = self.moved_px.get(instance_id, 0) + came + went
            if not self.visible_px[instance_id]:
                del self.visible_px[instance_id], self.moved_px[instance_id]
        self.cut.clear()
        self.cut.update(now.take(keyframe.edge_place).tolist())
        return lost.keys() | gained.keys()


def columns_of(sightings: Mapping[int, Sightings]) -> dict[str, Int64]:
    """Return the ``Sightings`` of all keyframes by seq as a few tables, which take less time.

    ``visible_px`` and ``moved_px`` int64 (N, 3): seq, instance id, pixels; ``cut`` int64 (M, 2).
    """
    visible = [(s, i, px) for s, of in sightings.items() for i, px in of.visible_px.items()]
    moved = [(s, i, px) for s, of in sightings.items() for i, px in of.moved_px.items()]
    cut = [(s, i) for s, of in sightings.items() for i in of.cut]
    return {
        "seq": np.array(list(sightings), np.int64),
        "visible_px": np.array(visible, np.int64).reshape(-1, 3),
        "moved_px": np.array(moved, np.int64).reshape(-1, 3),
        "cut": np.array(cut, np.int64).reshape(-1, 2),
    }


def from_columns(columns: Mapping[str, Int64]) -> dict[int, Sightings]:
    """Return what ``columns_of`` was given."""
    found = {seq: Sightings({}, set(), {}) for seq in columns["seq"].tolist()}
    for seq, instance_id, px in columns["visible_px"].tolist():
        found[seq].visible_px[instance_id] = px
    for seq, instance_id, px in columns["moved_px"].tolist():
        found[seq].moved_px[instance_id] = px
    for seq, instance_id in columns["cut"].tolist():
        found[seq].cut.add(instance_id)
    return found


def find_sightings(keyframe: Keyframe, instance_of_place: Int32) -> Sightings:
    """Return what ``keyframe`` shows; no view has been made of any of it."""
    visible_px = _count(instance_of_place.take(keyframe.place.reshape(-1)))
    cut = set(instance_of_place[keyframe.edge_place].tolist())
    return Sightings(visible_px, cut, dict(visible_px))


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


def _count(instance_id: Int32) -> dict[int, int]:
    """Return the full-resolution pixels of each instance in one id per sample; 0 is none."""
    samples = np.bincount(instance_id, minlength=1)
    shown = np.flatnonzero(samples[1:]) + 1
    return dict(zip(shown.tolist(), (samples[shown] * PX_PER_SAMPLE).tolist(), strict=True))


def _cropped(mask: Bool) -> tuple[Bool, int, int]:
    """Return a copy of the rows and columns that hold the mask, and the first of each."""
    left, top, width, height = cv2.boundingRect(mask.view(np.uint8))
    return mask[top : top + height, left : left + width].copy(), top, left


def _filled(mask: Bool) -> Bool:
    """Return the mask with holes of a sample or two closed: depth noise leaves its voxel."""
    kernel = np.ones((3, 3), np.uint8)
    return cv2.morphologyEx(mask.view(np.uint8), cv2.MORPH_CLOSE, kernel).astype(np.bool_)


def _without_strays(mask: Bool) -> Bool:
    """Return the mask's largest connected part and those that are not small beside it."""
    _, part, stats, _ = cv2.connectedComponentsWithStats(mask.view(np.uint8), connectivity=8)
    area: Array = stats[:, cv2.CC_STAT_AREA].copy()
    area[0] = 0
    return np.asarray((area >= MIN_PART * area.max())[part] & mask)
