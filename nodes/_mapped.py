"""The map of a scene with all else that decides what becomes of it: what a journal can repeat."""

import hashlib
import json
from collections import OrderedDict
from collections.abc import Iterator
from typing import Any

import numpy as np

from sceneq_core.mapping.delta import MapDelta
from sceneq_core.mapping.mapper import Mapper, MapperParams
from sceneq_core.mapping.proposals import Proposals
from sceneq_core.mapping.resumption import resumed, state_of
from sceneq_core.places.gazetteer import Gazetteer, GazetteerParams
from sceneq_core.places.visit import Visits
from sceneq_core.state import State, StateError
from sceneq_core.visits import visit_of
from sceneq_nodes._corrections import Corrections, correction_of
from sceneq_nodes._images import frame_from_message
from sceneq_nodes._journal import Entry
from sceneq_nodes._order import may_come
from sceneq_nodes._visit_json import visit_from_json, visit_json
from sceneq_nodes._wire import from_bytes, to_bytes
from sceneq_schemas.codec import decode
from sceneq_schemas.correction import PoseCorrection
from sceneq_schemas.frame import Frame
from sceneq_schemas.mask import Masks
from sceneq_schemas.proposal import ProposalSet
from sceneq_schemas.topics import FRAME, MASK, POSE_CORRECTION, PROPOSAL

KEYFRAME, REFUSED, CORRECTION = "keyframe", "refused", "correction"
PROPOSED, GIVEN, VISITED = "proposals", "given proposals", "visit"
MAX_GIVEN_BYTES = 1 << 30
REMEMBERED_SEQS = 65_536


class Mapped:
    """A ``Mapper``, the frames it was given, and the corrections that wait for theirs.

    Attributes:
        mapper: the map; change it only through the methods here.
        newest: seq and stamp of the last frame in the map, (-1, 0) before the first.
        visits: who came into the scene; change them only with ``enter``.
        gazetteer: the places of the map.
    """

    def __init__(self, params: MapperParams) -> None:
        self.mapper = Mapper(params)
        self.newest = (-1, 0)
        self.visits = Visits()
        self.gazetteer = Gazetteer(GazetteerParams())
        self._given = b""
        self._corrections = Corrections()
        self._done: OrderedDict[int, int] = OrderedDict()

    def stamp_of(self, seq: int) -> int | None:
        """Return the stamp of a frame that came before, ``None`` when it did not."""
        return self._done.get(seq)

    def may_come(self, frame: Frame) -> bool:
        """Tell whether the frame that ``frame`` is to come after has come."""
        visit = visit_of(frame.seq)
        oldest = next((seq for seq in self._done if visit_of(seq) == visit), None)
        return may_come(frame, self._done, oldest)

    @property
    def is_empty(self) -> bool:
        """Whether no frame came yet."""
        return not self._done

    def enter(self, data: bytes) -> None:
        """Note a visit, or what is known better of one; raise ``ValueError`` if it is none."""
        self.visits.take(visit_from_json(json.loads(data)))

    def integrate(self, frame: Frame, masks: Masks) -> MapDelta:
        """Add a keyframe at its newest pose; what is ``due`` by it has been applied.

        Raises:
            ValueError: it does not decode or fit; it counts as one that came, nothing else changed.
        """
        self.refuse(frame.seq, frame.stamp_ns)
        corrected = self._corrections.corrected(frame)
        taken = frame_from_message(corrected)
        delta = self.mapper.integrate(taken, masks.label_image)
        self.newest = (frame.seq, frame.stamp_ns)
        if not delta.quarantined:
            self.gazetteer.visit(taken)
        return delta

    def refuse(self, seq: int, stamp_ns: int) -> None:
        """Remember a frame that came."""
        self._done[seq] = stamp_ns
        if len(self._done) > REMEMBERED_SEQS:
            self._done.popitem(last=False)

    def offer(self, correction: PoseCorrection) -> bool:
        """Keep a correction until it is due; tell whether there was room for it."""
        return self._corrections.offer(correction)

    def due(self, frame_seq: int) -> Iterator[tuple[PoseCorrection, MapDelta | ValueError]]:
        """Apply the corrections that hold from ``frame_seq`` on, or from earlier; yield them all
        with the map that comes of each, or why it does not fit.
        """
        for correction in self._corrections.due(frame_seq):
            try:
                outcome: MapDelta | ValueError = self.mapper.correct(correction_of(correction))
                self.gazetteer.correct(correction_of(correction))
            except ValueError as error:
                outcome = error
            yield correction, outcome

    def propose(self, message: ProposalSet) -> None:
        """Take external masks; raise ``ValueError`` when they do not fit."""
        self.mapper.propose(
            Proposals(
                message.points_world,
                message.mask_id,
                message.point_id,
                message.score,
                message.label,
            )
        )

    def give(self, data: bytes) -> bool:
        """Take the masks that the graph itself names, a ``ProposalSet`` as bytes.

        Returns false, and does nothing, when they were the last ones given.
        """
        digest = hashlib.sha256(data).digest()
        if digest == self._given:
            return False
        self._given = digest
        self.propose(decode(ProposalSet, data, MAX_GIVEN_BYTES))
        return True

    def repeat(self, entry: Entry) -> list[MapDelta]:
        """Do again what ``entry`` of the journal tells of; return what was told of it then.

        Raises:
            ValueError: no entry of ours.
        """
        if entry.kind == KEYFRAME:
            frame, masks = from_bytes(FRAME, entry.first), from_bytes(MASK, entry.second)
            return [*self._applied(frame.seq), self.integrate(frame, masks)]
        if entry.kind == REFUSED:
            seq, stamp_ns = np.frombuffer(entry.first, "<i8").tolist()
            self.refuse(seq, stamp_ns)
            return self._applied(seq)
        if entry.kind == CORRECTION:
            self.offer(from_bytes(POSE_CORRECTION, entry.first))
            return self._applied(self.newest[0])
        if entry.kind == PROPOSED:
            self.propose(from_bytes(PROPOSAL, entry.first))
        elif entry.kind == GIVEN:
            self.give(entry.first)
        elif entry.kind == VISITED:
            self.enter(entry.first)
        else:
            raise ValueError(f"entry {entry.position} is of an unknown kind {entry.kind!r:.40}")
        return []

    def state(self, **beside: Any) -> State:
        """Return a copy of everything, and what the caller wants to find beside it."""
        waiting, poses, came = self._corrections.parts()
        return state_of(
            self.mapper,
            {
                "caller": beside,
                "newest": self.newest,
                "done": np.array(list(self._done.items()), np.int64).reshape(-1, 2),
                "corrections": [to_bytes(POSE_CORRECTION, message) for message in waiting],
                "poses": poses,
                "corrections_that_came": came,
                "given": self._given,
                "visits": json.dumps([visit_json(visit) for visit in self.visits.all()]),
                "gazetteer": self.gazetteer,
            },
        )

    def resume(self, state: State) -> dict[str, Any]:
        """Become what ``state`` was taken of; return what lay beside.

        Raises:
            StateError: another version's, or a map with other parameters; nothing has changed.
        """
        mapper, kept = resumed(state, self.mapper.params)
        try:
            waiting = [from_bytes(POSE_CORRECTION, data) for data in kept["corrections"]]
            beside: dict[str, Any] = kept["caller"]
            self.newest, self._given = kept["newest"], kept["given"]
            poses, done = kept["poses"], kept["done"].tolist()
            came = kept.get("corrections_that_came", {})
            visits = Visits(map(visit_from_json, json.loads(kept["visits"])))
            self.gazetteer = kept["gazetteer"]
        except (KeyError, ValueError) as error:
            raise StateError(f"no state of a mapping node: {error}") from error
        self.mapper, self._done = mapper, OrderedDict(done)
        self._corrections, self.visits = Corrections(waiting, poses, came), visits
        return beside

    def _applied(self, frame_seq: int) -> list[MapDelta]:
        outcomes = (outcome for _, outcome in self.due(frame_seq))
        return [outcome for outcome in outcomes if not isinstance(outcome, ValueError)]


def refused_bytes(seq: int, stamp_ns: int) -> bytes:
    """Return what the journal keeps of a refused frame."""
    return np.array([seq, stamp_ns], "<i8").tobytes()
