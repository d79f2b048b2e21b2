"""What is kept of a frame: its picture and which places of the map it shows."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64, Int32
from sceneq_core.frame import Frame
from sceneq_core.views.jpeg import jpeg_from_rgb

EDGE_SAMPLES = 2
"""An instance so close to the last measured row or column counts as cut by it."""


@dataclass(frozen=True, slots=True)
class Keyframe:
    """A frame without its depth.

    ``size`` (H, W) pixels; ``camera_world`` (3,) metres; ``place`` int32 (H/2, W/2) is what every
    second pixel of every second row shows, -1 = none; ``edge_place`` int32 are the places along
    the border of what the depth camera saw, which may be less than the image.
    """

    seq: int
    stamp_ns: int
    jpeg: bytes
    size: tuple[int, int]
    camera_world: Float64
    place: Int32
    edge_place: Int32


def make_keyframe(frame: Frame, place: Int32) -> Keyframe:
    """Return what is kept of ``frame``, which shows ``place`` (H/2, W/2)."""
    return Keyframe(
        seq=frame.seq,
        stamp_ns=frame.stamp_ns,
        jpeg=jpeg_from_rgb(frame.rgb),
        size=(frame.rgb.shape[0], frame.rgb.shape[1]),
        camera_world=frame.T_world_camera[:3, 3].copy(),
        place=place,
        edge_place=_edge(place),
    )


def _edge(place: Int32) -> Int32:
    """Return the places in the outermost rows and columns that show any."""
    known = place >= 0
    rows, columns = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
    if not len(rows):
        return np.zeros(0, np.int32)
    seen = place[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    sides = (
        seen[:EDGE_SAMPLES],
        seen[-EDGE_SAMPLES:],
        seen[:, :EDGE_SAMPLES],
        seen[:, -EDGE_SAMPLES:],
    )
    return np.unique(np.concatenate([side.ravel() for side in sides]))
