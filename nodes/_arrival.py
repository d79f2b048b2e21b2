"""The way of a source's frames into the scene: their numbers there, and their poses.

A source counts its frames from 0, in a frame of reference of its own. Mapping says which visit of
the scene it is; where its frame of reference lies is known (the first one founds the scene's), or
found by recognising places. Until then keyframes are held, as a submap in the scene's folder, and
nothing of them enters the map. What was never placed waits there for whoever comes next.
"""

import logging
import time
from collections.abc import Iterator

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.ingestor import Ingested
from sceneq_core.places.atlas import Atlas
from sceneq_core.places.relocaliser import Relocaliser, Relocation
from sceneq_core.places.visit import HERE, Visit, fingerprint_of
from sceneq_core.visits import visit_of
from sceneq_nodes._arrival_params import RELOCALISE, ArrivalParams
from sceneq_nodes._bus import Bus, Context
from sceneq_nodes._desk_calls import DeskCalls
from sceneq_nodes._held_files import Caller, put_away, waiting_text
from sceneq_nodes._held_frames import HeldFrames
from sceneq_nodes._left_visits import LeftVisits
from sceneq_nodes._set_aside import DamageError, StoreError
from sceneq_nodes._submap import Submap, in_scene
from sceneq_schemas.errors import DecodeError

log = logging.getLogger(__name__)

UNREADABLE = (StoreError, DamageError, DecodeError)


class Arrival:
    """Turns frames of a source into frames of the scene, now or as soon as their place is known."""

    def __init__(self, params: ArrivalParams, bus: Bus, context: Context, *, paced: bool) -> None:
        self._params, self._bus, self._context = params, bus, context
        self._desk = DeskCalls(bus, context.scene)
        self._atlas = Atlas(params.relocaliser.sighting)
        self._left = LeftVisits(context.store, context.robot, params.hold, params.quiet_s, bus)
        self._apart_s = 1.0 / params.release_hz if paced else 0.0
        self._next_s = self._look_s = self._study_s = self._quiet_s = 0.0
        self._visit: Visit | None = None
        self._T_world_odom: Float64 | None = None
        self._caller: Caller | None = None
        self._own: Submap | None = None

    @property
    def is_releasing(self) -> bool:
        """Whether keyframes that were held wait for their turn."""
        return any(submap.is_releasing for submap in self._submaps())

    @property
    def is_under_way(self) -> bool:
        """Whether keyframes that were held go on, or will in a moment."""
        return self.is_releasing or (self._own is not None and self._own.is_sure)

    def is_own(self, seq: int) -> bool:
        """Tell whether frame ``seq`` of the scene is of this source, not of a visit left behind."""
        return visit_of(seq) == self._number

    def take(self, frame: Ingested) -> Ingested | None:
        """Return ``frame`` as one of the scene, ``None`` while it has to wait."""
        if self._visit is None and frame.keyframe is not None:
            self._register(frame)
        if self._has_to_wait(frame.seq):
            self._hold(frame)
            return None
        T_world_odom = self._T_world_odom
        if T_world_odom is None or (not self._number and np.array_equal(T_world_odom, HERE)):
            return frame
        return in_scene(frame, self._number, T_world_odom)

    def idle(self) -> bool:
        """Look at what is held again, where the map has grown; tell whether that placed a visit.

        So a robot finds its place also when another one comes by where it was before.
        """
        if self._visit is None:
            return False
        self._learn_places()
        placed = self._study(self._own) if self._own is not None else False
        now_s = time.monotonic()
        if now_s >= self._study_s:
            waiting = next((submap for submap in self._left if submap.has_work), None)
            placed |= waiting is not None and self._study(waiting)
            spent_s = time.monotonic() - now_s
            self._study_s = now_s + spent_s / self._params.share
        return placed

    def next(self) -> Ingested | None:
        """Return the next keyframe that was held and may go on now."""
        now_s = time.monotonic()
        submap = next((one for one in self._submaps() if one.is_releasing), None)
        if submap is None or now_s < self._next_s:
            return None
        self._next_s = now_s + self._apart_s
        try:
            return submap.next()
        except UNREADABLE as error:
            self._lose(submap, error)
            return None
        finally:
            self._report()

    def acknowledge(self, seq: int) -> None:
        """Forget a keyframe that was held: frame ``seq`` is in the map."""
        for submap in self._submaps():
            try:
                submap.acknowledge(seq)
            except StoreError as error:
                log.warning("%s", error)
        self._drop_finished()

    def give_up(self, seq: int) -> None:
        """Leave a keyframe that was held where it is: nobody said that ``seq`` is in the map."""
        for submap in self._submaps():
            submap.give_up(seq)
        self._drop_finished()

    def close(self) -> None:
        """Leave what is held to the next one who comes, and say how much that is."""
        self._left.close()
        own, self._own = self._own, None
        if own is None:
            return
        held = own.held
        if len(held) and held.is_durable:
            log.info("visit %d: %d keyframes wait in %s", own.number, len(held), held.path)
        elif len(held):
            self._bus.count("frames_unplaced", len(held))
            log.warning("%d keyframes never found their place in the scene", len(held))
        held.close()

    @property
    def _number(self) -> int:
        return 0 if self._visit is None else self._visit.number

    def _submaps(self) -> Iterator[Submap]:
        if self._own is not None:
            yield self._own
        yield from self._left

    def _has_to_wait(self, seq: int) -> bool:
        if self._visit is None:
            return False
        if self._T_world_odom is None:
            return True
        own = self._own
        if own is None or seq < own.held.oldest_seq:  # of an earlier run: it went before
            return False
        return own.is_releasing or own.knows(seq)

    def _register(self, frame: Ingested) -> None:
        """Ask mapping which visit this is; without one it is the first."""
        assert frame.keyframe is not None
        fingerprint = fingerprint_of(frame.keyframe)
        caller = Caller(self._context.robot, frame.seq, frame.stamp_ns, fingerprint)
        told = self._desk.register(caller, self._params.start)
        self._visit = told or Visit(0, caller.robot, "", frame.seq, frame.stamp_ns, 0, HERE)
        self._caller, self._T_world_odom = caller, self._visit.T_world_odom
        folder = self._context.store
        if folder is not None and (folder / caller.file_name).exists():
            self._open_own()
        if self._T_world_odom is None:
            number = self._visit.number
            log.info("visit %d: nothing is known of where it starts; looking around", number)
            self._report()

    def _open_own(self) -> Submap:
        assert self._visit is not None
        assert self._caller is not None
        folder = self._context.store
        if folder is not None and not (folder / self._caller.file_name).exists():
            self._left.let_go_of_old(self._params.visits - 1)
        held = HeldFrames.of(self._caller, folder, self._params.hold)
        self._own = Submap(self._visit, held, self._recogniser())
        return self._own

    def _recogniser(self) -> Relocaliser:
        """Return one that knows the places that are known."""
        return Relocaliser(self._params.relocaliser, self._atlas)

    def _hold(self, frame: Ingested) -> None:
        """Keep a keyframe, and find out with it where the frame of reference lies."""
        try:
            own = self._own or self._open_own()
            own.correct(frame.corrected)
            if frame.keyframe is None or own.knows(frame.seq):
                return
            if own.hold(frame):
                self._bus.count("frames_let_go")
        except StoreError as error:
            self._bus.count("frames_lost")
            log.error("keyframe %d is lost: %s", frame.seq, error)
            return
        if self._T_world_odom is None:
            self._learn_places()
            self._believe(own, own.see(frame))
            self._quiet_s = time.monotonic() + self._params.settle_s
        self._report()

    def _study(self, submap: Submap) -> bool:
        """Do a piece of work for a visit that waits; tell whether it is placed now."""
        if not submap.has_work:
            return False
        patient = submap is self._own and time.monotonic() < self._quiet_s
        try:
            return self._believe(submap, submap.study(patient=patient))
        except UNREADABLE as error:
            self._lose(submap, error)
            return False

    def _believe(self, submap: Submap, found: Relocation | None) -> bool:
        """Tell mapping where a frame of reference lies, and go on from there."""
        if found is None:
            return False
        if not self._desk.settle(submap.number, found):
            self._quiet_s = time.monotonic() + self._params.settle_s
            return False
        submap.T_world_odom = found.T_world_odom
        if submap is self._own:
            self._T_world_odom = found.T_world_odom
        self._report()
        return True

    def _learn_places(self) -> None:
        """Fetch the places of the map, if somebody waits for new ones."""
        if time.monotonic() < self._look_s:
            return
        own = None if self._own is None else self._own.held.path
        self._left.find(self._register_left, self._recogniser, own)
        waiting = [one for one in self._submaps() if one.T_world_odom is None]
        places = self._desk.places() if waiting or self._T_world_odom is None else None
        if places is not None:
            changed = self._atlas.learn(places)
            for submap in waiting:
                submap.relocaliser.renew(changed)
        self._look_s = time.monotonic() + self._params.look_again_s
        if any(self._submaps()):
            self._report()

    def _register_left(self, caller: Caller) -> Visit | None:
        return self._desk.register(caller, RELOCALISE)

    def _lose(self, submap: Submap, error: Exception) -> None:
        """Put what a visit holds aside: it cannot be read."""
        held = submap.held
        log.error("%d held keyframes of visit %d: %s", len(held), submap.number, error)
        if submap is not self._own:
            self._left.set_aside(submap, error)
            return
        self._own = None
        self._bus.count("frames_lost", len(held))
        held.close()
        put_away(held.path, error)

    def _drop_finished(self) -> None:
        if not any(submap.is_over for submap in self._submaps()):
            return
        self._left.drop_finished()
        if self._own is not None and self._own.is_over:
            self._own.held.close()
            self._own = None
        self._report()

    def _report(self) -> None:
        own = self._own
        held = 0 if own is None else len(own.held)
        self._bus.report(arrival=self._told(held), held=held, unplaced=self._unplaced())

    def _told(self, held: int) -> str:
        if self._own is None or not held:
            return "in place"
        standing = self._own.relocaliser.standing
        told = f"{'released' if self._T_world_odom is not None else 'relocalising'}: {held} held"
        if self._T_world_odom is None and standing.recognised:
            told += f", {standing.recognised} recognised"
        return told

    def _unplaced(self) -> str:
        waiting = [one for one in self._submaps() if one.T_world_odom is None]
        return waiting_text(len(waiting), sum(len(one.held) for one in waiting))
