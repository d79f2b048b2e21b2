"""What is kept of a frame: its picture and which places of the map it shows."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Array, Float64, Int32, Int64
from sceneq_core.frame import Frame
from sceneq_core.views.jpeg import jpeg_from_rgb
from sceneq_core.views.place import PlaceImage

MARGIN_SAMPLES = 1
"""How close to the last measured row or column counts as cut by it."""


@dataclass(frozen=True, slots=True)
class Keyframe:
    """A frame without its depth.

    ``size`` (H, W) pixels; ``camera_world`` (3,) metres; ``edge_run`` int32 are the runs of
    ``places`` at the border of what the depth camera saw, which may be less than the image.
    """

    seq: int
    stamp_ns: int
    jpeg: bytes
    size: tuple[int, int]
    camera_world: Float64
    places: PlaceImage
    edge_run: Int32

    def instance_image(self, instance_of_place: Int32) -> Int32:
        """Return the instance of every pixel at half resolution, 0 = none."""
        return self.places.expand(instance_of_place[self.places.place])


def make_keyframe(frame: Frame, places: PlaceImage) -> Keyframe:
    """Return what is kept of ``frame``, which shows ``places``."""
    return Keyframe(
        seq=frame.seq,
        stamp_ns=frame.stamp_ns,
        jpeg=jpeg_from_rgb(frame.rgb),
        size=(frame.rgb.shape[0], frame.rgb.shape[1]),
        camera_world=frame.T_world_camera[:3, 3].copy(),
        places=places,
        edge_run=_edge_runs(places),
    )


def _edge_runs(places: PlaceImage) -> Int32:
    """Return the runs that touch the outermost rows and columns with known places."""
    known = places.expand(places.place >= 0)
    rows, columns = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
    if not len(rows):
        return np.zeros(0, np.int32)
    run = places.expand(np.arange(len(places.place), dtype=np.int32))
    top, bottom = _both_ends(rows)
    left, right = _both_ends(columns)
    edges = (run[:top], run[bottom:], run[:, :left], run[:, right:])
    return np.unique(np.concatenate([edge.ravel() for edge in edges]))


def _both_ends(known: Int64 | Array) -> tuple[int, int]:
    """Return where the first margin ends and the last one starts."""
    return int(known[0]) + 1 + MARGIN_SAMPLES, int(known[-1]) - MARGIN_SAMPLES
