"""A hand-held camera's way through a room, past everything that can be seen well."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.source import Camera
from sceneq_tools.room.camera.glance import HANDHELD
from sceneq_tools.room.camera.lookout import LEAST_PIXELS, Lookout
from sceneq_tools.room.camera.pace import Pace
from sceneq_tools.room.camera.patrol import Patrol
from sceneq_tools.room.room import Room


def camera_path(
    room: Room,
    frames: int,
    rate_hz: float,
    seed: int,
    pace: Pace | None = None,
    camera: Camera = HANDHELD,
) -> list[Float64]:
    """Return one T_world_camera (4, 4) per frame, metres, OpenCV axes; equal for equal arguments.

    Few frames are the beginning of a long tour: it starts where most is to be seen.

    Raises:
        ValueError: nowhere to walk, nothing to see, or a pace nobody can hold.
    """
    patrol = Patrol(Lookout(room, seed, camera), rate_hz, seed, pace)
    return list(islice(patrol.poses(), frames))


@dataclass(frozen=True, slots=True)
class Coverage:
    """Ids of what can be seen well from the free floor, and of what of that a path left out."""

    visible: tuple[int, ...]
    missed: tuple[int, ...]

    @property
    def share(self) -> float:
        """The part of the visible things that were seen."""
        return 1.0 - len(self.missed) / len(self.visible) if self.visible else 1.0


def coverage(
    room: Room, poses: Sequence[Float64], seed: int = 0, camera: Camera = HANDHELD
) -> Coverage:
    """Return what a path shows, by half of the pixels that make a thing seen well."""
    lookout = Lookout(room, seed, camera)
    best = np.max([lookout.scores(lookout.glance.at(T).pixels) for T in poses], axis=0)
    visible = lookout.counts & (lookout.best >= LEAST_PIXELS)
    ids = lookout.glance.ids
    return Coverage(
        visible=tuple(ids[visible].tolist()), missed=tuple(ids[visible & (best < 0.5)].tolist())
    )
