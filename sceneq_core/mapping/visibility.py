"""Which superpoints a frame shows, and which of its 2D segments dominates each."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Int32, Int64, UInt16
from sceneq_core.mapping.colours import NO_COLOURS, Colours
from sceneq_core.mapping.contacts import NO_CONTACTS, Contacts
from sceneq_core.mapping.rows import counted, first_of_each

NO_LABEL = -1


@dataclass(frozen=True, slots=True)
class Visible:
    """The superpoints in one keyframe, parallel rows sorted by ``superpoint_id`` int32 (S,).

    ``label`` int32 (S,) is the value in the label image of the segment that shows most of it, -1
    where none does; ``pixels`` int64 (S,) counts the surface points that show the superpoint.
    ``contacts`` says which of them lie side by side, ``colours`` what colour they have.
    """

    superpoint_id: Int32
    label: Int32
    pixels: Int64
    contacts: Contacts = NO_CONTACTS
    colours: Colours = NO_COLOURS


NOTHING_VISIBLE = Visible(np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros(0, np.int64))


def visible_superpoints(
    superpoint_of_point: Int32, label_of_point: UInt16, min_pixels: int
) -> Visible:
    """Return the superpoints with at least ``min_pixels`` and the segment that dominates each.

    ``superpoint_of_point`` int32 (N,), -1 = none, and ``label_of_point`` uint16 (N,), 0 = none,
    are parallel over the surface points of the keyframe.
    """
    known = np.flatnonzero(superpoint_of_point >= 0)
    superpoint = superpoint_of_point.take(known)
    label = label_of_point.take(known).astype(np.int64)
    labels = int(label.max(initial=0)) + 1
    pair, count = counted(superpoint * labels + label)
    pair_superpoint, pair_label = pair // labels, pair % labels
    total = np.bincount(pair_superpoint, count)
    enough = np.flatnonzero(total >= max(min_pixels, 1))
    dominant = np.full(len(total), NO_LABEL, np.int32)
    # Pixels without a segment are no opinion: the edges of 2D masks are often drawn in.
    shown = np.flatnonzero(pair_label > 0)
    order = shown[np.lexsort((pair_label[shown], -count[shown], pair_superpoint[shown]))]
    most = first_of_each(order, pair_superpoint)
    dominant[pair_superpoint[most]] = pair_label[most]
    return Visible(enough.astype(np.int32), dominant[enough], total[enough].astype(np.int64))
