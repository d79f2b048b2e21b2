"""Registers who comes into the scene, and tells what the map knows of its places."""

import json
import logging
from collections.abc import Callable, Mapping
from dataclasses import replace
from threading import Lock
from typing import Any

import numpy as np

from sceneq_core.places.visit import HERE, Visit
from sceneq_nodes._bus import Bus, QueryError, Reply, Request
from sceneq_nodes._mapped import Mapped
from sceneq_nodes._pages import paged
from sceneq_nodes._place_message import place_message
from sceneq_nodes._visit_json import visit_json
from sceneq_nodes._wire import json_bytes, to_bytes
from sceneq_schemas.place import PlaceSet
from sceneq_schemas.topics import ID, PLACES, VISIT

log = logging.getLogger(__name__)

RELOCALISE, SAME_FRAME = "relocalise", "same_frame"
STARTS = (RELOCALISE, SAME_FRAME)
FIRST = "the first one"
MAX_EVIDENCE = 500


class VisitDesk:
    """Answers ingest: which visit a source is, where the scene's places are, which one it found.

    A request without content lists all visits. What is answered has been kept (``keep``) before.
    """

    def __init__(self, mapped: Mapped, lock: Lock, keep: Callable[[bytes], None]) -> None:
        self._mapped = mapped
        self._lock = lock
        self._keep = keep

    def open(self, bus: Bus, epoch: int, scene: str) -> None:
        """Serve the visits and the places of the map ``epoch``."""
        self._epoch = epoch
        bus.serve(VISIT, self._answer, scene=scene)
        bus.serve(PLACES, paged(self._places), scene=scene)

    def _answer(self, request: Request) -> Reply:
        asked = _asked(request)
        with self._lock:
            if not asked:
                told: Any = {"visits": [visit_json(visit) for visit in self._mapped.visits.all()]}
            else:
                chosen = settled if "T_world_odom" in asked else arriving
                told = visit_json(self._note(chosen(self._mapped, asked)))
        return Reply(json_bytes(told), VISIT.encoding)

    def _note(self, visit: Visit) -> Visit:
        if self._mapped.visits.get(visit.number) is not visit:
            try:
                data = json_bytes(visit_json(visit))
                self._mapped.enter(data)
            except ValueError as error:
                raise _bad(str(error)) from error
            self._keep(data)
            known = "not known yet" if visit.T_world_odom is None else visit.evidence
            log.info("visit %d of %s: where it lies: %s", visit.number, visit.robot, known)
        return visit

    def _places(self, request: Request) -> Reply | None:
        """Answer with all places, or with nothing when the asker has them (``?have=E:SEQ``)."""
        with self._lock:
            places, seq = list(self._mapped.gazetteer), self._mapped.gazetteer.revision
        if request.parameters.get("have") == f"{self._epoch}:{seq}":
            return None
        message = PlaceSet(self._epoch, seq, tuple(map(place_message, places)))
        return Reply(to_bytes(PLACES, message), PLACES.encoding)


def arriving(mapped: Mapped, asked: Mapping[str, Any]) -> Visit:
    """Return the visit that a source's first keyframe begins, or goes on with.

    The first one into an empty map founds its frame of reference. Any other one lies in it already
    (``start: same_frame``) or has to be found in it.

    Raises:
        QueryError: not what a source says.
    """
    start = asked.get("start", RELOCALISE)
    if start not in STARTS:
        raise _bad(f"start {start!r:.40}")
    new = _new(asked)
    is_here = start == SAME_FRAME
    known = mapped.visits.find(new)
    if known is not None:
        is_open = is_here and known.T_world_odom is None
        return mapped.visits.settled(known.number, HERE, SAME_FRAME) if is_open else known
    if not len(mapped.visits) and mapped.stamp_of(new.first_seq) == new.first_stamp_ns:
        return replace(new, number=0, T_world_odom=HERE, evidence=FIRST)
    others = {visit.robot for visit in mapped.visits.all()} - {new.robot}
    founds = not new.origin and mapped.is_empty and not others
    return replace(
        new,
        number=mapped.visits.next_number(has_frames=not mapped.is_empty),
        T_world_odom=HERE if founds or is_here else None,
        evidence=FIRST if founds else SAME_FRAME if is_here else "",
    )


def _new(asked: Mapping[str, Any]) -> Visit:
    """Return what a source says of itself, not numbered yet."""
    robot, origin = (str(asked.get(name, "")) for name in ("robot", "origin"))
    numbers = [asked.get(name, 0) for name in ("seq", "stamp_ns", "fingerprint")]
    if not ID.fullmatch(robot) or (origin and not ID.fullmatch(origin)):
        raise _bad(f"robot {robot!r:.40}, origin {origin!r:.40}")
    if not all(type(number) is int for number in numbers) or numbers[0] < 0:
        raise _bad(f"seq, stamp_ns, fingerprint: {numbers!r:.80}")
    return Visit(-1, robot, origin, *numbers)


def settled(mapped: Mapped, asked: Mapping[str, Any]) -> Visit:
    """Return a visit with the frame of reference that its robot has found.

    Raises:
        QueryError: no such visit, or no rigid motion.
    """
    try:
        T_world_odom = np.array(asked["T_world_odom"], np.float64).reshape(4, 4)
        evidence = str(asked.get("evidence", ""))[:MAX_EVIDENCE]
        return mapped.visits.settled(int(asked["visit"]), T_world_odom, evidence)
    except (KeyError, TypeError, ValueError) as error:
        raise _bad(str(error)) from error


def _asked(request: Request) -> dict[str, Any]:
    """Return the JSON object of a request; raise ``QueryError`` for anything else."""
    try:
        asked = json.loads(request.payload or b"{}")
    except (ValueError, RecursionError) as error:
        raise _bad(f"not JSON: {error}") from error
    if not isinstance(asked, dict):
        raise _bad("not a JSON object")
    return asked


def _bad(what: str) -> QueryError:
    return QueryError("bad_request", f"visit: {what}", "say robot, seq, stamp_ns, start")
