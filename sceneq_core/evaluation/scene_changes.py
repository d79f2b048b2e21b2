"""Does a map follow a room that people change? Thing by thing, between two moments of it."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Int64
from sceneq_core.evaluation.mask_iou import mask_iou

ARRIVED, MOVED, VANISHED, STAYED = "arrived", "moved", "vanished", "stayed"
FOUND_IOU = 0.25
"""From this overlap on an instance is the thing: that of AP25."""
GHOST_SHARE = 0.25
"""A place counts as empty when no more of the surface that was there is left."""
MIN_POINTS = 30
"""Things with fewer points before and after are not judged."""


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """Truth and map at one time, at the N points where the truth then has surface.

    Attributes:
        thing: int64 (N,) number of the true thing of each point, 0 = of none.
        instance: int64 (N,) instance of the map's nearest point, 0 = none.
    """

    thing: Int64
    instance: Int64


@dataclass(frozen=True, slots=True)
class Fate:
    """What became of a thing, and whether the map knows.

    Attributes:
        thing: its number.
        kind: ``arrived``, ``moved``, ``vanished`` or ``stayed``.
        before: best instance and its IoU at the first moment, (0, 0.0) = none.
        after: the same at the second.
        ghost: share of the surface at its former place, now empty, that the map still has; 0 for
            things that stayed or arrived.
    """

    thing: int
    kind: str
    before: tuple[int, float]
    after: tuple[int, float]
    ghost: float

    @property
    def is_judged(self) -> bool:
        """A thing that stayed and was not found before cannot get lost."""
        return self.kind != STAYED or self.before[1] >= FOUND_IOU

    @property
    def is_known(self) -> bool:
        """The thing is found where it is, and its former place is empty."""
        found = self.kind == VANISHED or self.after[1] >= FOUND_IOU
        return found and self.ghost <= GHOST_SHARE

    @property
    def kept_id(self) -> bool:
        """Whether the same instance stands for it."""
        return self.before[0] == self.after[0] != 0


def fates(
    before: Moment, after: Moment, left: Int64, vacated: Bool, changed: Iterable[int]
) -> tuple[Fate, ...]:
    """Return what became of every thing seen well at either moment, by number.

    Args:
        before: the first moment, N points.
        after: the second.
        left: int64 (N,) instance that the second map has at the points of the first moment.
        vacated: bool (N,) points of the first moment where the second truth has no surface.
        changed: things that were moved, brought or taken between the two.

    Raises:
        ValueError: ``left`` or ``vacated`` are not as long as ``before``.
    """
    if not len(before.thing) == len(left) == len(vacated):
        raise ValueError(f"left, vacated: {len(left)}, {len(vacated)} for {len(before.thing)}")
    was, now, edited = _best(before), _best(after), set(changed)
    result = []
    for thing in sorted(was.keys() | now.keys()):
        kind = _kind(thing in was, thing in now, thing in edited)
        place = (before.thing == thing) & vacated if kind in (MOVED, VANISHED) else None
        ghost = 0.0 if place is None or not place.any() else float((left[place] > 0).mean())
        nothing = (0, 0.0)
        result.append(Fate(thing, kind, was.get(thing, nothing), now.get(thing, nothing), ghost))
    return tuple(result)


def _kind(was_there: bool, is_there: bool, was_edited: bool) -> str:
    if not was_edited:
        return STAYED
    if not is_there:
        return VANISHED
    return MOVED if was_there else ARRIVED


def _best(moment: Moment) -> dict[int, tuple[int, float]]:
    """Return the best instance of every thing with enough points, and its IoU."""
    iou, things, instances = mask_iou(moment.thing, moment.instance)
    size = np.bincount(moment.thing)
    best = {}
    for row, thing in enumerate(things.tolist()):
        if size[thing] < MIN_POINTS:
            continue
        column = int(iou[row].argmax()) if len(instances) else -1
        found = column >= 0 and iou[row, column] > 0
        best[thing] = (int(instances[column]), float(iou[row, column])) if found else (0, 0.0)
    return best
