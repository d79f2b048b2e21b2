"""Grows the map from keyframes and their 2D segments.

Reads   sceneq/frame/<robot>/<sensor>/v1 and sceneq/mask/<scene>/v1 (latest wins), joined by seq.
        sceneq/pose/<robot>/correction/v1, from ingest or any SLAM system: the map moves along.
        sceneq/proposal/<scene>/v1: masks of a 3D network, which found instances.
Writes  sceneq/map/<scene>/delta/v1 after every keyframe: epoch = start time in ms, seq from 1.
Serves  sceneq/map/<scene>/@snapshot/v1: the whole map as one message.
Rate    that of the keyframes; they are integrated in the order in which they become complete.
Bad     a frame without its segments (or the reverse) waits until ``max_waiting`` newer ones came,
        then it counts as ``frames_unmatched``; a seq that is already in the map counts as
        ``frames_repeated``; a frame that does not decode or fit counts as ``frames_refused``, one
        that would harm the map as ``frames_quarantined`` (it may be let in later); a correction
        that does not fit, or one of too many, counts as ``corrections_refused``, masks that do not
        fit as ``proposals_refused``.
"""

import logging
import threading
from collections import OrderedDict
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from sceneq_core.mapping.mapper import Mapper, MapperParams
from sceneq_core.mapping.proposals import Proposals, ProposalSource
from sceneq_nodes._backends import build
from sceneq_nodes._bus import Bus, Context, Received, Reply, Request
from sceneq_nodes._convert import map_delta_message
from sceneq_nodes._corrections import Corrections, correction_of
from sceneq_nodes._epoch import new_epoch
from sceneq_nodes._images import frame_from_message
from sceneq_nodes._wire import to_bytes
from sceneq_schemas.correction import PoseCorrection
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.frame import Frame as FrameMessage
from sceneq_schemas.mask import Masks
from sceneq_schemas.proposal import ProposalSet
from sceneq_schemas.topics import FRAME, MAP_DELTA, MAP_SNAPSHOT, MASK, POSE_CORRECTION, PROPOSAL

log = logging.getLogger(__name__)

REMEMBERED_SEQS = 65_536
CORRECTIONS_DEPTH = 8


@dataclass(frozen=True, slots=True)
class MappingParams:
    """``max_waiting`` frames, and as many masks, wait for their other half.

    ``proposals``: kind and parameters of where external 3D masks come from.
    """

    mapper: MapperParams = field(default_factory=MapperParams)
    max_waiting: int = 16
    proposals: dict[str, Any] = field(default_factory=lambda: {"kind": "none"})

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
        self._frames: OrderedDict[int, FrameMessage] = OrderedDict()
        self._masks: OrderedDict[int, Masks] = OrderedDict()
        self._done: OrderedDict[int, None] = OrderedDict()
        self._corrections = Corrections()
        self._reasons: set[str] = set()
        self._lock = threading.Lock()

    def open(self, bus: Bus) -> None:
        """Start an empty map, subscribe to both inputs and serve the snapshot."""
        self._bus = bus
        self._mapper = Mapper(self._params.mapper)
        source: ProposalSource = build("proposals", self._params.proposals, ("proposals",))
        if (proposals := source.load()) is not None:
            self._mapper.propose(proposals)
        self._epoch, self._seq, self._marked = new_epoch(), 0, 0
        self._newest = (-1, 0)
        context, depth = self._context, self._params.max_waiting
        bus.subscribe(FRAME, depth=depth, robot=context.robot, sensor=context.sensor)
        bus.subscribe(MASK, depth=depth, scene=context.scene)
        bus.subscribe(POSE_CORRECTION, depth=CORRECTIONS_DEPTH, robot=context.robot)
        bus.subscribe(PROPOSAL, depth=1, scene=context.scene)
        bus.serve(MAP_SNAPSHOT, self._snapshot, scene=context.scene)

    def step(self, received: Received | None) -> None:
        """Keep one half of a keyframe, or integrate the keyframe when both are there."""
        if received is None:
            self._mark_silence()
            return
        message = received.message
        if received.topic is POSE_CORRECTION:
            self._take_correction(message)
            return
        if received.topic is PROPOSAL:
            self._propose(message)
            return
        if message.seq in self._done:
            if received.topic is FRAME:
                self._bus.count("frames_repeated")
                self._publish_unchanged(message.seq, message.stamp_ns)
            return
        half = self._frames if received.topic is FRAME else self._masks
        half[message.seq] = message
        if message.seq in self._frames and message.seq in self._masks:
            self._integrate(self._frames.pop(message.seq), self._masks.pop(message.seq))
        self._drop_oldest(half)

    def close(self) -> None:
        """Nothing to release."""

    def _integrate(self, frame: FrameMessage, masks: Masks) -> None:
        _remember(self._done, frame.seq)
        self._correct(frame.seq)
        frame = self._corrections.corrected(frame)
        try:
            with self._lock:
                delta = self._mapper.integrate(frame_from_message(frame), masks.label_image)
                self._seq += 1
        except (DecodeError, ValueError) as error:
            self._bus.count("frames_refused")
            log.warning("frame %d refused: %s", frame.seq, error)
            self._publish_unchanged(frame.seq, frame.stamp_ns)  # nobody need send it again
            return
        message = map_delta_message(delta, self._epoch, self._seq)
        self._bus.publish(MAP_DELTA, message, scene=self._context.scene)
        self._newest = (frame.seq, frame.stamp_ns)
        if delta.quarantined:
            self._say_quarantined(frame, delta.quarantined)
        else:
            self._bus.count("frames_integrated")
        let_in, counts = self._mapper.let_in, self._mapper.counts()
        self._bus.report(frame_seq=frame.seq, quarantined_let_in=let_in, **counts)

    def _say_quarantined(self, frame: FrameMessage, reason: str) -> None:
        """Count it and, once for every kind of reason, log it."""
        self._bus.count("frames_quarantined")
        kind = reason.partition(":")[0]
        if kind not in self._reasons:
            self._reasons.add(kind)
            where = np.round(frame.T_world_camera[:3, 3], 2).tolist()
            log.warning("frame %d kept out of the map, camera at %s: %s", frame.seq, where, reason)

    def _take_correction(self, message: PoseCorrection) -> None:
        if not self._corrections.offer(message):
            self._refuse_correction(message, "too many wait for their frame")
        self._correct(self._newest[0])

    def _correct(self, frame_seq: int) -> None:
        """Apply the corrections that hold from ``frame_seq`` on, or from earlier."""
        for correction in self._corrections.due(frame_seq):
            try:
                with self._lock:
                    delta = self._mapper.correct(correction_of(correction))
                    self._seq += 1
            except ValueError as error:
                self._refuse_correction(correction, str(error))
                continue
            self._bus.count("corrections_applied")
            message = map_delta_message(delta, self._epoch, self._seq)
            try:
                self._bus.publish(MAP_DELTA, message, scene=self._context.scene)
            except ValueError as error:  # too large: the gap in seq sends readers to the snapshot
                self._bus.count("corrections_unsent")
                log.warning("map after correction %d not sent: %s", correction.seq, error)

    def _refuse_correction(self, correction: PoseCorrection, reason: str) -> None:
        self._bus.count("corrections_refused")
        log.warning("correction %d:%d refused: %s", correction.epoch, correction.seq, reason)

    def _propose(self, message: ProposalSet) -> None:
        try:
            self._mapper.propose(
                Proposals(
                    message.points_world,
                    message.mask_id,
                    message.point_id,
                    message.score,
                    message.label,
                )
            )
        except ValueError as error:
            self._bus.count("proposals_refused")
            log.warning("proposals of %s refused: %s", message.source, error)
        else:
            self._bus.count("proposals_taken")

    def _mark_silence(self) -> None:
        """Let readers see, once, that nothing follows: else a lost last delta shows to nobody."""
        if self._seq != self._marked:
            self._publish_unchanged(*self._newest)
            self._marked = self._seq

    def _publish_unchanged(self, seq: int, stamp_ns: int) -> None:
        """Say that frame ``seq`` is in the map: whoever sends it again missed that."""
        with self._lock:
            delta = self._mapper.unchanged(seq, stamp_ns)
            self._seq += 1
        message = map_delta_message(delta, self._epoch, self._seq)
        self._bus.publish(MAP_DELTA, message, scene=self._context.scene)

    def _drop_oldest(self, half: OrderedDict[int, Any]) -> None:
        if len(half) > self._params.max_waiting:
            seq, _ = half.popitem(last=False)
            self._bus.count("frames_unmatched")
            log.warning("frame %d: the other half never came", seq)

    def _snapshot(self, request: Request) -> Reply:
        """Copy the map between two keyframes; encoding does not hold mapping up."""
        with self._lock:
            snapshot, seq = self._mapper.snapshot(), self._seq
        message = map_delta_message(snapshot, self._epoch, seq)
        return Reply(to_bytes(MAP_SNAPSHOT, message), MAP_SNAPSHOT.encoding)


def _remember(done: OrderedDict[int, None], seq: int) -> None:
    done[seq] = None
    if len(done) > REMEMBERED_SEQS:
        done.popitem(last=False)
