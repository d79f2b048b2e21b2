"""Grows the map from keyframes and their 2D segments.

Reads   sceneq/frame/<robot>/<sensor>/v1 and sceneq/mask/<scene>/v1 (latest wins), joined by seq.
        sceneq/pose/<robot>/correction/v1, from ingest or any SLAM system: the map moves along.
        sceneq/proposal/<scene>/v1: masks of a 3D network, which found instances.
Writes  sceneq/map/<scene>/delta/v1 after every keyframe: epoch = when the map was begun, in ms;
        seq from 1, with a leap at every start. With a store (docs/durability.md) what entered the
        map is on disk before its delta is sent, and the map goes on where the last process ended.
Serves  sceneq/map/<scene>/@snapshot/v1: the whole map as one message;
        sceneq/map/<scene>/@journal/v1?epoch=E;after=SEQ: the last deltas, one by one, or with
        ;merged=1 as one change; @places/v1 and sceneq/visit/<scene>: see _visit_desk.
Rate    that of the keyframes; they are integrated in the order in which they become complete,
        or that of ``after`` where ingest names it: a frame that comes again is not overtaken.
Bad     a frame without its segments (or the reverse) waits until ``max_waiting`` newer ones came,
        then it counts as ``frames_unmatched``; a seq that is already in the map counts as
        ``frames_repeated``; a frame that does not decode or fit counts as ``frames_refused``, one
        that would harm the map as ``frames_quarantined`` (it may be let in later); a correction
        that does not fit, or one of too many, counts as ``corrections_refused``, masks that do not
        fit as ``proposals_refused``; a frame of another recording under a seq that is in the map
        as ``frames_foreign``; a disk that fails as ``store_failed``, the map goes on without it.
"""

import logging
import threading
import time
from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import Any, ClassVar

import numpy as np

from sceneq_core.mapping.delta import MapDelta
from sceneq_core.mapping.mapper import MapperParams
from sceneq_core.mapping.proposals import Proposals, ProposalSource
from sceneq_nodes._backends import build
from sceneq_nodes._bus import Bus, Context, QueryError, Received, Reply, Request
from sceneq_nodes._convert import map_delta_message, proposal_message
from sceneq_nodes._kept_deltas import open_deltas
from sceneq_nodes._map_store import open_store
from sceneq_nodes._mapped import (
    CORRECTION,
    GIVEN,
    KEYFRAME,
    PROPOSED,
    REFUSED,
    VISITED,
    Mapped,
    refused_bytes,
)
from sceneq_nodes._pages import paged
from sceneq_nodes._recent_deltas import FORGOTTEN, journal_reply, wanted_deltas
from sceneq_nodes._store_params import StoreParams
from sceneq_nodes._visit_desk import VisitDesk
from sceneq_nodes._wire import to_bytes
from sceneq_schemas.codec import encode
from sceneq_schemas.correction import PoseCorrection
from sceneq_schemas.frame import Frame
from sceneq_schemas.mask import Masks
from sceneq_schemas.proposal import ProposalSet
from sceneq_schemas.topics import (
    FRAME,
    MAP_DELTA,
    MAP_JOURNAL,
    MAP_SNAPSHOT,
    MASK,
    POSE_CORRECTION,
    PROPOSAL,
    Topic,
)

log = logging.getLogger(__name__)

CORRECTIONS_DEPTH = 8


@dataclass(frozen=True, slots=True)
class MappingParams:
    """``max_waiting`` frames, and as many masks, wait for their other half.

    ``proposals``: kind and parameters of where external 3D masks come from. ``robots``: whose
    frames enter the map beside those of the graph's own robot.
    """

    mapper: MapperParams = field(default_factory=MapperParams)
    max_waiting: int = 16
    proposals: dict[str, Any] = field(default_factory=lambda: {"kind": "none"})
    robots: tuple[str, ...] = ()
    store: StoreParams = field(default_factory=StoreParams)

    def __post_init__(self) -> None:
        if self.max_waiting < 1:
            raise ValueError(f"max_waiting: must be at least 1, got {self.max_waiting}")


class Mapping:
    """Owns the map of one scene."""

    Params: ClassVar[type] = MappingParams
    idle_s: ClassVar[float] = 1.0

    def __init__(self, params: MappingParams, context: Context) -> None:
        self._params = params
        self._context = context
        self._frames: OrderedDict[int, Frame] = OrderedDict()
        self._masks: OrderedDict[int, Masks] = OrderedDict()
        self._reasons: set[str] = set()
        self._lock = threading.Lock()

    def open(self, bus: Bus) -> None:
        """Bring back the map or start an empty one, subscribe to the inputs, serve the snapshot."""
        self._bus = bus
        source: ProposalSource = build("proposals", self._params.proposals, ("proposals",))
        self._mapped = Mapped(self._params.mapper)
        self._store = open_store(self._context.store, self._params.store, self._mapped, bus.count)
        self._epoch, self._seq = self._store.epoch, self._store.first_seq
        self._marked = 0
        self._recent = open_deltas(self._store, bus.count)
        if (given := source.load()) is not None:
            self._take_given(given)
        context, depth = self._context, self._params.max_waiting
        for robot in (context.robot, *self._params.robots):
            bus.subscribe(FRAME, depth=depth, robot=robot, sensor=context.sensor)
            bus.subscribe(POSE_CORRECTION, depth=CORRECTIONS_DEPTH, robot=robot)
        bus.subscribe(MASK, depth=depth, scene=context.scene)
        bus.subscribe(PROPOSAL, depth=1, scene=context.scene)
        bus.serve(MAP_SNAPSHOT, paged(self._snapshot), scene=context.scene)
        bus.serve(MAP_JOURNAL, paged(self._journal), scene=context.scene)
        keep = partial(self._store.keep, self._seq, VISITED)
        VisitDesk(self._mapped, self._lock, keep).open(bus, self._epoch, context.scene)
        self._report()

    def step(self, received: Received | None) -> None:
        """Keep one half of a keyframe, or integrate the keyframe when both are there."""
        with self._lock:
            if received is None:
                self._mark_silence()
            elif received.topic is POSE_CORRECTION:
                self._take_correction(received.message)
            elif received.topic is PROPOSAL:
                self._propose(received.message)
            else:
                self._take_half(received.topic, received.message)

    def close(self) -> None:
        """Let go of the files of the store."""
        self._recent.close()
        self._store.close()

    def _take_half(self, topic: Topic, message: Frame | Masks) -> None:
        stamp_ns = self._mapped.stamp_of(message.seq)
        if stamp_ns is not None:
            if topic is FRAME:
                self._say_known(message, stamp_ns)
            return
        half: OrderedDict[int, Any] = self._frames if topic is FRAME else self._masks
        half[message.seq] = message
        while (seq := self._next_complete()) is not None:
            self._integrate(self._frames.pop(seq), self._masks.pop(seq))
        self._drop_oldest(half)

    def _next_complete(self) -> int | None:
        """Return a frame that is there with its masks, and after the one it is to come after."""
        complete = (frame for seq, frame in self._frames.items() if seq in self._masks)
        return next((frame.seq for frame in complete if self._mapped.may_come(frame)), None)

    def _say_known(self, frame: Frame | Masks, stamp_ns: int) -> None:
        """Answer a frame whose seq is in the map, so that nobody sends it again."""
        if frame.stamp_ns == stamp_ns:
            self._bus.count("frames_repeated")
        else:
            self._bus.count("frames_foreign")
            told = "the map is of another recording, under another scene name this one has its own"
            self._warn_once("foreign", "frame %d, stamp %d: %s", frame.seq, frame.stamp_ns, told)
        self._publish_unchanged(frame.seq, frame.stamp_ns)

    def _integrate(self, frame: Frame, masks: Masks) -> None:
        """Change the map, commit what changed it, and only then tell what came of it."""
        began_s = time.monotonic()
        deltas = self._correct(frame.seq)
        try:
            delta = self._mapped.integrate(frame, masks)
        except ValueError as error:
            self._bus.count("frames_refused")
            log.warning("frame %d refused: %s", frame.seq, error)
            self._store.keep(self._seq, REFUSED, refused_bytes(frame.seq, frame.stamp_ns))
            self._publish_all(deltas)
            self._publish_unchanged(frame.seq, frame.stamp_ns)  # nobody need send it again
            return
        self._store.keep(self._seq, KEYFRAME, frame, masks)
        self._publish_all([*deltas, delta])
        self._say_integrated(frame, delta)
        self._store.worked(time.monotonic() - began_s, self._seq)

    def _say_integrated(self, frame: Frame, delta: MapDelta) -> None:
        if not delta.quarantined:
            self._bus.count("frames_integrated")
        else:
            self._bus.count("frames_quarantined")
            kind = delta.quarantined.partition(":")[0]
            where = np.round(frame.T_world_camera[:3, 3], 2).tolist()
            message = "frame %d kept out of the map, camera at %s: %s"
            self._warn_once(kind, message, frame.seq, where, delta.quarantined)
        self._report()

    def _report(self) -> None:
        mapper = self._mapped.mapper
        counts, let_in = mapper.counts(), mapper.let_in
        self._bus.report(frame_seq=self._mapped.newest[0], quarantined_let_in=let_in, **counts)

    def _take_correction(self, message: PoseCorrection) -> None:
        if not self._mapped.offer(message):
            self._refuse_correction(message, "too many wait for their frame")
            return
        self._store.keep(self._seq, CORRECTION, message)
        self._publish_all(self._correct(self._mapped.newest[0]))

    def _correct(self, frame_seq: int) -> list[MapDelta]:
        """Apply the corrections that hold from ``frame_seq`` on, or from earlier."""
        deltas = []
        for correction, outcome in self._mapped.due(frame_seq):
            if isinstance(outcome, ValueError):
                self._refuse_correction(correction, str(outcome))
            else:
                self._bus.count("corrections_applied")
                deltas.append(outcome)
        return deltas

    def _refuse_correction(self, correction: PoseCorrection, reason: str) -> None:
        self._bus.count("corrections_refused")
        log.warning("correction %d:%d refused: %s", correction.epoch, correction.seq, reason)

    def _propose(self, message: ProposalSet) -> None:
        try:
            self._mapped.propose(message)
        except ValueError as error:
            self._bus.count("proposals_refused")
            log.warning("proposals of %s refused: %s", message.source, error)
        else:
            self._store.keep(self._seq, PROPOSED, message)
            self._bus.count("proposals_taken")

    def _take_given(self, proposals: Proposals) -> None:
        """Take the masks of the graph's own source, unless the map came back with them."""
        data = encode(proposal_message(proposals, self._params.proposals["kind"]))
        if self._mapped.give(data):
            self._store.keep(self._seq, GIVEN, data)

    def _mark_silence(self) -> None:
        """Let readers see, once, that nothing follows: else a lost last delta shows to nobody."""
        if self._seq != self._marked:
            self._publish_unchanged(*self._mapped.newest)
            self._marked = self._seq

    def _publish_unchanged(self, seq: int, stamp_ns: int) -> None:
        """Say that frame ``seq`` is in the map: whoever sends it again missed that."""
        self._publish_all([self._mapped.mapper.unchanged(seq, stamp_ns)])

    def _publish_all(self, deltas: Iterable[MapDelta]) -> None:
        for delta in deltas:
            self._seq += 1
            message = map_delta_message(delta, self._epoch, self._seq)
            self._recent.add(message)
            try:
                self._bus.publish(MAP_DELTA, message, scene=self._context.scene)
            except ValueError as error:  # too large: the gap in seq sends readers to the snapshot
                self._bus.count("deltas_unsent")
                log.warning("map %d:%d not sent: %s", self._epoch, self._seq, error)
        self._bus.report(map=f"{self._epoch}:{self._seq}")

    def _drop_oldest(self, half: OrderedDict[int, Any]) -> None:
        if len(half) > self._params.max_waiting:
            seq, _ = half.popitem(last=False)
            self._bus.count("frames_unmatched")
            log.warning("frame %d: the other half never came", seq)

    def _snapshot(self, request: Request) -> Reply:
        """Copy the map between two keyframes; encoding does not hold mapping up."""
        with self._lock:
            snapshot, seq = self._mapped.mapper.snapshot(), self._seq
        message = map_delta_message(snapshot, self._epoch, seq)
        return Reply(to_bytes(MAP_SNAPSHOT, message), MAP_SNAPSHOT.encoding)

    def _journal(self, request: Request) -> Reply:
        """Answer with the deltas beyond ``after``, or say that they are forgotten."""
        epoch, after = wanted_deltas(request)
        with self._lock:
            deltas, seq = self._recent.after(after), self._seq
        if epoch not in (0, self._epoch) or deltas is None:
            raise QueryError(FORGOTTEN, "not all of these deltas are known", "ask for @snapshot")
        return journal_reply(request, self._epoch, seq, deltas)

    def _warn_once(self, kind: str, message: str, *values: Any) -> None:
        if kind not in self._reasons:
            self._reasons.add(kind)
            log.warning(message, *values)
