"""The places in a room from which its things are seen well, found by looking from many."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64, Int64
from sceneq_core.ingest.source import Camera
from sceneq_tools.room.camera.floor_plan import FloorPlan
from sceneq_tools.room.camera.glance import HANDHELD, Glance
from sceneq_tools.room.room import Room, Thing
from sceneq_tools.room.truth.boxes import world_box

SECTORS = 12
"""Directions from which a thing is tried."""
RANGE_M = (0.8, 2.6)
APART_M = (1.2, 1.9)
NEAR_M = 0.7
"""How far one stands from furniture, to see what is on it, and from one thing on it."""
GAZE_EVERY_M = 1.2
"""Wider things are looked at in several places."""
EYE_M = (1.20, 1.60)
LEAST_PIXELS = 300
"""A patch of 17x17: less is not seen well from anywhere."""
WELL = 0.4
"""A thing is seen well with this part of the pixels that the best viewpoint shows of it."""
NOSE_M = 1.0
"""Looking at something this near shows little else."""


@dataclass(frozen=True, slots=True, eq=False)
class Viewpoint:
    """Where to stand and where to look; ``scores`` (N,) 0 to 1 say how well each thing is seen.

    Attributes:
        place: index of a free cell of the plan.
        eye_m: height of the camera.
        yaw, pitch: radians; yaw from +x to +y, pitch up.
    """

    place: int
    eye_m: float
    yaw: float
    pitch: float
    scores: Float64


class Lookout:
    """The viewpoints of one room.

    Attributes:
        viewpoints: those that show anything, never empty.
        best: int64 (N,) most pixels of each thing in ``glance.ids`` from any of them.
    """

    def __init__(self, room: Room, seed: int, camera: Camera = HANDHELD) -> None:
        """Look around; raise ``ValueError`` when nobody can walk here or nothing is to be seen."""
        self._room = room
        self._seed = seed
        self.plan = FloorPlan(room)
        self.glance = Glance(room, camera)
        rng = np.random.default_rng((seed, 1))
        tries = [
            try_
            for thing in room.things
            if _draws_the_eye(thing, room)
            for gaze in _gazes(thing)
            for try_ in self._tries(gaze, rng.uniform(*APART_M), rng)
        ]
        if not tries:
            raise ValueError(f"{room.kind} {room.seed}: nothing to look at from the free floor")
        seen = [self.glance.at(self.pose(*try_)) for try_ in tries]
        pixels = np.array([s.pixels for s in seen])
        self.best = pixels.max(axis=0)
        self.counts = np.array([not thing.is_stuff for thing in room.things])
        near = np.array([min(s.middle_m / NOSE_M, 1.0) for s in seen])
        scores = self.scores(pixels) * near[:, None]
        self.viewpoints = tuple(
            Viewpoint(*try_, score) for try_, score in zip(tries, scores, strict=True)
        )

    def scores(self, pixels: Int64) -> Float64:
        """Return how well (..., N) things with so many pixels are seen, 0 to 1."""
        enough = np.maximum(WELL * self.best, LEAST_PIXELS)
        worth = self.counts & (self.best >= LEAST_PIXELS)
        return np.asarray(np.minimum(pixels / enough, 1.0) * worth)

    def pose(self, place: int, eye_m: float, yaw: float, pitch: float) -> Float64:
        """Return T_world_camera (4, 4) of a camera held still at a free cell."""
        return looking(np.array([*self.plan.places[place], eye_m]), yaw, pitch)

    def close_to(self, thing_id: int) -> Viewpoint | None:
        """Return where most is seen of one thing from near; ``None`` when it is hidden or gone."""
        column = np.flatnonzero(self.glance.ids == thing_id)
        if not len(column):
            return None
        gaze = world_box(self._room.thing(thing_id)).mean(axis=0)
        rng = np.random.default_rng((self._seed, 2, thing_id))
        tries = self._tries(gaze, NEAR_M, rng)
        pixels = [self.glance.at(self.pose(*try_)).pixels for try_ in tries]
        shown = [int(p[column[0]]) for p in pixels]
        if max(shown, default=0) == 0:
            return None
        best = int(np.argmax(shown))
        return Viewpoint(*tries[best], self.scores(pixels[best]))

    def _tries(
        self, gaze: Float64, wanted: float, rng: np.random.Generator
    ) -> list[tuple[int, float, float, float]]:
        """Return one place per direction, at a distance that shows the thing and its sides."""
        apart = self.plan.places - gaze[:2]
        distance = np.hypot(*apart.T)
        sector = np.floor(np.arctan2(apart[:, 1], apart[:, 0]) / (2 * np.pi) * SECTORS) % SECTORS
        tries = []
        for k in range(SECTORS):
            inside = (sector == k) & (distance > min(RANGE_M[0], wanted)) & (distance < RANGE_M[1])
            if inside.any():
                candidates = np.flatnonzero(inside)
                place = int(candidates[np.abs(distance[candidates] - wanted).argmin()])
                tries.append(self._towards(place, gaze, rng))
        return tries

    def _towards(
        self, place: int, gaze: Float64, rng: np.random.Generator
    ) -> tuple[int, float, float, float]:
        eye_m = float(np.clip(gaze[2] + 0.55 + rng.uniform(-0.1, 0.1), *EYE_M))
        x, y, z = gaze - [*self.plan.places[place], eye_m]
        return place, eye_m, float(np.arctan2(y, x)), float(np.arctan2(z, np.hypot(x, y)))


def looking(eye: Float64, yaw: float, pitch: float) -> Float64:
    """Return T_world_camera (4, 4) with OpenCV axes: x right, y down, z forward."""
    forward = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), np.sin(pitch)])
    right = np.array([np.sin(yaw), -np.cos(yaw), 0.0])
    T_world_camera = np.eye(4)
    T_world_camera[:3, :3] = np.stack([right, np.cross(forward, right), forward], axis=1)
    T_world_camera[:3, 3] = eye
    return T_world_camera


def _draws_the_eye(thing: Thing, room: Room) -> bool:
    """Look at furniture and what hangs on walls: what stands on furniture is seen with it."""
    if thing.is_stuff:
        return False
    return thing.support is None or room.thing(thing.support).is_stuff


def _gazes(thing: Thing) -> list[Float64]:
    """Return the points (3,) to look at: the top where things stand, or the front of tall ones."""
    low, high = world_box(thing)
    middle, extent = (low + high) / 2, high - low
    height = np.clip(high[2] if low[2] < 0.5 else middle[2], 0.3, 1.25)
    along = int(extent[1] > extent[0])
    count = max(1, int(np.ceil(extent[along] / GAZE_EVERY_M - 0.5)))
    gazes = []
    for k in range(count):
        gaze = np.array([middle[0], middle[1], height])
        gaze[along] += ((k + 0.5) / count - 0.5) * extent[along]
        gazes.append(gaze)
    return gazes
