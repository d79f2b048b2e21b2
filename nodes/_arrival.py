"""The way of a source's frames into the scene: their numbers there, and their poses.

A source counts its frames from 0, in a frame of reference of its own. Mapping says which visit of
the scene it is; where its frame of reference lies is known (the first one founds the scene's), or
found by recognising places. Until then keyframes are held, and nothing of them enters the map.
"""

import logging
import time
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.checks import need_at_least
from sceneq_core.ingest.ingestor import Ingested
from sceneq_core.ingest.transforms import nearest_rigid
from sceneq_core.places.place import PlaceParams, place_of
from sceneq_core.places.relocaliser import Relocaliser, RelocaliserParams, Relocation
from sceneq_core.places.visit import fingerprint_of
from sceneq_core.visits import seq_in_scene
from sceneq_nodes._bus import Bus, Context, QueryError
from sceneq_nodes._fetch import Fetch
from sceneq_nodes._held_frames import HeldFrames
from sceneq_nodes._place_message import place_from_message
from sceneq_nodes._set_aside import DamageError, StoreError
from sceneq_nodes._wire import from_bytes, json_bytes
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.topics import PLACES, VISIT

log = logging.getLogger(__name__)

STARTS = ("relocalise", "same_frame")
TRIES = 3


@dataclass(frozen=True, slots=True)
class ArrivalParams:
    """What to do where the map has frames of other sources already.

    ``start``: ``same_frame``, the poses lie in the map's frame of reference, or ``relocalise``.
    Until that has succeeded the newest ``hold`` keyframes wait, about 1 MB each on disk; then
    ``release_hz`` of them follow each second, or as fast as the graph takes them where nothing is
    to be lost. Places are asked for again after ``look_again_s``: another robot's map may grow.
    """

    start: str = "relocalise"
    hold: int = 300
    release_hz: float = 3.0
    look_again_s: float = 2.0
    relocaliser: RelocaliserParams = field(default_factory=RelocaliserParams)

    def __post_init__(self) -> None:
        if self.start not in STARTS:
            raise ValueError(f"start: expected {' or '.join(STARTS)}, got {self.start!r}")
        need_at_least(self, 1, "hold")
        need_at_least(self, 0.1, "release_hz")
        need_at_least(self, 0, "look_again_s")


class Arrival:
    """Turns frames of a source into frames of the scene, now or as soon as their place is known."""

    def __init__(self, params: ArrivalParams, bus: Bus, context: Context, *, paced: bool) -> None:
        self._params = params
        self._bus = bus
        self._context = context
        self._apart_s = 1.0 / params.release_hz if paced else 0.0
        self._next_s = self._look_s = 0.0
        self._visit: int | None = None
        self._T_world_odom: Float64 | None = None
        self._held: HeldFrames | None = None
        self._relocaliser = Relocaliser(params.relocaliser)
        self._corrected: dict[int, Float64] = {}
        self._have = ""

    @property
    def is_releasing(self) -> bool:
        """Whether keyframes that were held wait for their turn."""
        return self._held is not None and self._T_world_odom is not None

    def take(self, frame: Ingested) -> Ingested | None:
        """Return ``frame`` as one of the scene, ``None`` while it has to wait."""
        if self._visit is None and frame.keyframe is not None:
            self._register(frame)
        if self._T_world_odom is None or self._held is not None:
            self._hold(frame)
            return None
        return self._in_scene(frame)

    def idle(self) -> bool:
        """Look at what is held again, where the map has grown; tell whether that found the place.

        So a robot finds its place also when another one comes by where it was before.
        """
        if self._held is None or self._T_world_odom is not None:
            return False
        self._learn_places()
        self._believe(self._relocaliser.look_again())
        return self._T_world_odom is not None

    def next(self) -> Ingested | None:
        """Return the next keyframe that was held and may go on now."""
        now_s = time.monotonic()
        if not self.is_releasing or now_s < self._next_s:
            return None
        self._next_s = now_s + self._apart_s
        assert self._held is not None
        try:
            frame = self._held.pop() if len(self._held) else None
        except (StoreError, DamageError, DecodeError) as error:
            self._bus.count("frames_lost", len(self._held))
            log.error("%d held keyframes are lost: %s", len(self._held), error)
            frame = None
        if frame is None or not len(self._held):
            self._held.close()
            self._held = None
        self._report()
        return None if frame is None else self._in_scene(frame)

    def close(self) -> None:
        """Let go of what is held, and say how much that was."""
        if self._held is None:
            return
        if len(self._held):
            self._bus.count("frames_unplaced", len(self._held))
            log.warning("%d keyframes never found their place in the scene", len(self._held))
        self._held.close()
        self._held = None

    def _register(self, frame: Ingested) -> None:
        """Ask mapping which visit this is; without one it is the first."""
        assert frame.keyframe is not None
        asked = {
            "robot": self._context.robot,
            "seq": frame.seq,
            "stamp_ns": frame.stamp_ns,
            "fingerprint": fingerprint_of(frame.keyframe),
            "start": self._params.start,
        }
        told = self._ask(asked)
        if told is None:
            self._visit, self._T_world_odom = 0, np.eye(4)
            return
        known = told["T_world_odom"]
        self._visit = int(told["visit"])
        self._T_world_odom = None if known is None else np.array(known, np.float64)
        if known is None:
            log.info("visit %d: nothing is known of where it starts; looking around", self._visit)

    def _ask(self, asked: dict[str, Any]) -> Any:
        for _ in range(TRIES):
            try:
                replies = self._bus.ask(VISIT, payload=json_bytes(asked), scene=self._context.scene)
                if replies:
                    return from_bytes(VISIT, replies[-1].payload)
            except (QueryError, DecodeError) as error:
                self._bus.count("visit_failed")
                log.warning("mapping did not take the visit: %s", error)
        return None

    def _hold(self, frame: Ingested) -> None:
        """Keep a keyframe, and find out with it where the frame of reference lies."""
        self._corrected |= frame.corrected
        if frame.keyframe is None:
            return
        if self._held is None:
            context = self._context
            self._held = HeldFrames(context.store, context.robot, self._params.hold)
        try:
            if self._held.add(frame):
                self._bus.count("frames_let_go")
        except StoreError as error:
            self._bus.count("frames_lost")
            log.error("keyframe %d is lost: %s", frame.seq, error)
        if self._T_world_odom is None:
            self._look(frame)
        self._report()

    def _look(self, frame: Ingested) -> None:
        self._learn_places()
        assert frame.keyframe is not None
        self._believe(self._relocaliser.see(place_of(frame.keyframe, PlaceParams())))

    def _believe(self, found: Relocation | None) -> None:
        """Tell mapping where the frame of reference lies, and go on from there."""
        if found is None:
            return
        evidence = _words(found)
        told = self._ask(
            {
                "visit": self._visit,
                "T_world_odom": found.T_world_odom.tolist(),
                "evidence": evidence,
            }
        )
        if told is not None:
            log.info("visit %s found its place: %s", self._visit, evidence)
            self._bus.count("relocalised")
            self._T_world_odom = found.T_world_odom

    def _learn_places(self) -> None:
        """Fetch the places of the map, unless they are those known."""
        if time.monotonic() < self._look_s:
            return
        fetch = Fetch(self._bus, PLACES, {"have": self._have}, scene=self._context.scene)
        try:
            while not fetch.done:
                fetch.step()
            if fetch.message is not None:
                places = fetch.message
                self._relocaliser.learn([place_from_message(place) for place in places.places])
                self._have = f"{places.epoch}:{places.seq}"
        except (QueryError, DecodeError) as error:
            self._bus.count("places_failed")
            log.warning("places: %s", error)
        self._look_s = time.monotonic() + self._params.look_again_s

    def _in_scene(self, frame: Ingested) -> Ingested:
        """Return ``frame`` with the scene's numbers, at its newest pose, in the scene's frame."""
        visit, T_world_odom = self._visit or 0, self._T_world_odom
        if T_world_odom is None or (not visit and np.array_equal(T_world_odom, np.eye(4))):
            return frame
        seq = seq_in_scene(visit, frame.seq)
        pose = nearest_rigid(T_world_odom @ self._corrected.get(frame.seq, frame.T_world_camera))
        corrected = {
            seq_in_scene(visit, old): nearest_rigid(T_world_odom @ T)
            for old, T in frame.corrected.items()
        }
        keyframe = frame.keyframe and replace(frame.keyframe, seq=seq, T_world_camera=pose)
        return replace(frame, seq=seq, T_world_camera=pose, keyframe=keyframe, corrected=corrected)

    def _report(self) -> None:
        held, standing = 0 if self._held is None else len(self._held), self._relocaliser.standing
        doing = "released" if self._T_world_odom is not None else "relocalising"
        told = f"{doing}: {held} frames held"
        if self._T_world_odom is None and standing.recognised:
            told += f", {standing.recognised} of {standing.seen} recognised"
        self._bus.report(arrival=told if held else "in place", held=held)


def _words(found: Relocation) -> str:
    return (
        f"{found.keyframes} keyframes recognised at {found.places} places, {found.features} "
        f"features, trust {found.trust:.2f}, spread {100 * found.spread_m:.1f} cm"
    )
