"""The earlier keyframes that can say whether a new one fits, and how the camera moved since."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.mapping.reference_view import ReferenceView


@dataclass(frozen=True, slots=True)
class Comparison:
    """Samples of surface on which views agree, and those that one saw where another saw none.

    ``cover`` is the share of the view's own samples that the others saw as surface too.
    """

    agreeing: int
    contradicting: int
    cover: float

    @property
    def samples(self) -> int:
        """Samples that say anything."""
        return self.agreeing + self.contradicting

    @property
    def agreement(self) -> float:
        """Share that agrees, 1 without samples."""
        return self.agreeing / self.samples if self.samples else 1.0


@dataclass(frozen=True, slots=True)
class Motion:
    """How far the camera came, metres and radians, in ``seconds``; 0 or less is not known."""

    metres: float
    radians: float
    seconds: float

    @classmethod
    def between(cls, earlier: ReferenceView, later: ReferenceView) -> "Motion":
        """Return the motion between two views."""
        one, other = earlier.T_world_camera, later.T_world_camera
        cosine = (np.trace(one[:3, :3].T @ other[:3, :3]) - 1.0) / 2.0
        return cls(
            float(np.linalg.norm(other[:3, 3] - one[:3, 3])),
            float(np.arccos(np.clip(cosine, -1.0, 1.0))),
            (later.stamp_ns - earlier.stamp_ns) * 1e-9,
        )

    def exceeds(self, speed_m_s: float, turn_rad_s: float) -> bool:
        """Tell whether it was faster than this; never after a restart of the clock."""
        if self.seconds <= 0.0:
            return False
        return self.metres > speed_m_s * self.seconds or self.radians > turn_rad_s * self.seconds

    def __str__(self) -> str:
        """Return it for a log line."""
        turn = np.degrees(self.radians)
        return f"{self.metres:.1f} m and {turn:.0f} degrees in {self.seconds:.1f} s"


def compare(view: ReferenceView, others: Iterable[ReferenceView]) -> Comparison:
    """Hold ``view`` against ``others``, both ways.

    A sample of ``view`` agrees when any of the others saw that surface too, for the scene may have
    changed since older ones; it contradicts when some saw free space there and none the surface.
    A sample of the others contradicts when ``view`` looks through it.
    """
    others = tuple(others)
    agrees = np.zeros(len(view.points_world), np.bool_)
    free = np.zeros(len(view.points_world), np.bool_)
    for other in others:
        seen = other.witness(view.points_world)
        agrees |= seen.agrees
        free |= seen.free
    theirs = [other.points_world for other in others] or [view.points_world[:0]]
    back = view.witness(np.concatenate(theirs))
    return Comparison(
        int(agrees.sum() + back.agrees.sum()),
        int((free & ~agrees).sum() + back.free.sum()),
        float(agrees.mean()) if len(agrees) else 0.0,
    )


class Witnesses:
    """The newest view of every place, at most ``max_views``: the oldest are forgotten.

    A place is a cube of ``place_m`` for the camera and one for what it looks at.
    """

    def __init__(self, asked: int, max_views: int, place_m: float) -> None:
        self._asked, self._max_views, self._place_m = asked, max_views, place_m
        self._views: dict[tuple[int, ...], ReferenceView] = {}

    def add(self, view: ReferenceView) -> None:
        """Keep ``view`` in place of the one before it there."""
        both = np.concatenate((view.T_world_camera[:3, 3], view.look_world))
        place = tuple(np.floor(both / self._place_m).astype(int).tolist())
        self._views.pop(place, None)
        self._views[place] = view
        if len(self._views) > self._max_views:
            del self._views[next(iter(self._views))]

    def ask(self, view: ReferenceView) -> Comparison:
        """Compare ``view`` with those that look at nearly the same."""
        return compare(view, (self._views[place] for place in self._nearest(view)))

    def overrule(self, view: ReferenceView, min_agreement: float) -> None:
        """Forget all that tell another story than ``view``: the scene has changed."""
        self._views = {
            place: other
            for place, other in self._views.items()
            if compare(view, (other,)).agreement >= min_agreement
        }

    def _nearest(self, view: ReferenceView) -> list[tuple[int, ...]]:
        places = list(self._views)
        look = np.array([v.look_world for v in self._views.values()]).reshape(-1, 3)
        gap = np.linalg.norm(look - view.look_world, axis=1)
        return [places[i] for i in np.argsort(gap, kind="stable")[: self._asked]]

    def correct(self, T_world_camera: Mapping[int, Float64]) -> None:
        """Move the views of frames by seq."""
        views, self._views = self._views, {}
        for view in views.values():
            pose = T_world_camera.get(view.seq)
            self.add(view if pose is None else view.moved(pose))
