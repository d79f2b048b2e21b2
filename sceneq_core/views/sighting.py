"""How much of each instance a keyframe shows, and the view that comes of it."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy import ndimage

from sceneq_core.arrays import Array, Bool, Float64, Int32
from sceneq_core.views.place import STRIDE_PX, PlaceImage
from sceneq_core.views.view import View

PX_PER_SAMPLE = STRIDE_PX * STRIDE_PX
MIN_PART = 0.2
"""A part of a mask smaller than this share of the largest part is taken for stray pixels."""

Window = tuple[slice, slice]


@dataclass(frozen=True, slots=True)
class Sighting:
    """One instance in one keyframe: full-resolution pixels, where, and whether the border cuts it.

    ``window`` are the rows and columns at half resolution that hold all of its pixels.
    """

    visible_px: int
    window: Window
    cut: bool


@dataclass(frozen=True, slots=True)
class Keyframe:
    """What is kept of a frame: its JPEG, where it was taken and the places it shows."""

    seq: int
    stamp_ns: int
    jpeg: bytes
    size: tuple[int, int]
    camera_world: Float64
    places: PlaceImage

    def instance_image(self, instance_of_place: Int32) -> Int32:
        """Return the instance of every pixel at half resolution, 0 = none."""
        return self.places.expand(instance_of_place[self.places.place])


def find_sightings(keyframe: Keyframe, instance_of_place: Int32) -> dict[int, Sighting]:
    """Return every instance that ``keyframe`` shows, by instance id."""
    places = keyframe.places
    of_run = instance_of_place[places.place]
    samples = np.bincount(of_run, weights=places.length)
    windows = ndimage.find_objects(places.expand(of_run))
    seen = _extent(places)
    return {
        int(i): Sighting(int(samples[i]) * PX_PER_SAMPLE, windows[i - 1], _cuts(windows[i - 1], seen))
        for i in np.flatnonzero(samples[1:]) + 1
    }


def make_view(
    keyframe: Keyframe, sighting: Sighting, instance_image: Int32, instance_id: int
) -> View:
    """Return the view of an instance, without stray pixels."""
    mask = _without_strays(instance_image[sighting.window] == instance_id)
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    mask = mask[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1].copy()
    top = sighting.window[0].start + rows[0]
    left = sighting.window[1].start + columns[0]
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


def _extent(places: PlaceImage) -> Window:
    """Return the rows and columns with any known place: depth cameras see less than the image."""
    known = places.expand((places.place >= 0).astype(np.uint8))
    found = ndimage.find_objects(known)
    return found[0] if found else (slice(0, 0), slice(0, 0))


def _cuts(window: Window, extent: Window) -> bool:
    """Tell whether the window reaches the edge of what the camera saw."""
    return any(
        part.start <= whole.start + 1 or part.stop >= whole.stop - 1
        for part, whole in zip(window, extent, strict=True)
    )


def _without_strays(mask: Bool) -> Bool:
    """Return the mask's largest connected part and those that are not small beside it."""
    _, part, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    area: Array = stats[:, cv2.CC_STAT_AREA].copy()
    area[0] = 0
    return np.asarray((area >= MIN_PART * area.max())[part] & mask)
