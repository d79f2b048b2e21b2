"""What is kept of a frame: its picture and which places of the map it shows."""

from dataclasses import dataclass, replace

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int32
from sceneq_core.frame import Frame
from sceneq_core.views.jpeg import jpeg_from_rgb

BLOCK_PLACES = 256
EDGE_SAMPLES = 2
"""An instance so close to the last measured row or column counts as cut by it."""


@dataclass(frozen=True, slots=True)
class Keyframe:
    """A frame without its depth.

    ``size`` (H, W) pixels; ``camera_world`` (3,) metres; ``place`` int32 (H/2, W/2) is what every
    second pixel of every second row shows, -1 = none; ``edge_place`` int32 are the places along
    the border of what the depth camera saw, which may be less than the image; ``block`` int32 are
    the blocks of ``BLOCK_PLACES`` consecutive places it shows, a quick test before a close look.
    """

    seq: int
    stamp_ns: int
    jpeg: bytes
    size: tuple[int, int]
    camera_world: Float64
    place: Int32
    edge_place: Int32
    block: Int32

    def touched(self, changed: Bool, changed_block: Bool) -> Int32:
        """Return the place of every pixel that shows a changed one, int32 (N,).

        ``changed`` is by place, with a last entry for -1; ``changed_block`` sums it up by block.
        """
        if not changed_block.take(self.block).any():
            return self.block[:0]
        place = self.place.reshape(-1)
        return place.take(np.flatnonzero(changed.take(place)))

    def moved(self, place_now: Int32) -> "Keyframe":
        """Return the keyframe with its surfaces where they are by ``place_now`` (P + 1,)."""
        place = place_now[self.place]
        return replace(self, place=place, edge_place=_edge(place), block=_blocks(place))


def changed_blocks(changed: Bool) -> Bool:
    """Return which blocks of ``BLOCK_PLACES`` hold a changed place."""
    starts = np.arange(0, len(changed), BLOCK_PLACES)
    blocks: Bool = np.logical_or.reduceat(changed, starts)
    return blocks


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
        block=_blocks(place),
    )


def _blocks(place: Int32) -> Int32:
    return np.unique(place[place >= 0] // BLOCK_PLACES)


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
