"""One kept scene made part of another: where they overlap, and then what was seen there again."""

import contextlib
import json
import shutil
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.places.gazetteer import Gazetteer, GazetteerParams
from sceneq_core.places.place import Place
from sceneq_core.places.relocaliser import Relocaliser, RelocaliserParams, Relocation
from sceneq_core.places.visit import HERE, Visit, fingerprint_of
from sceneq_core.visits import seq_of, visit_of
from sceneq_nodes._backends import load
from sceneq_nodes._bus import Context, QueryError
from sceneq_nodes._corrections import correction_of
from sceneq_nodes._fetch import Fetch
from sceneq_nodes._held_files import copy_held
from sceneq_nodes._images import frame_from_message
from sceneq_nodes._mapped import CORRECTION, KEYFRAME, VISITED
from sceneq_nodes._params import validate
from sceneq_nodes._place_message import place_from_message
from sceneq_nodes._scene_folder import SceneFolder
from sceneq_nodes._visit_json import visit_from_json
from sceneq_nodes._wire import from_bytes, json_bytes
from sceneq_schemas.topics import FRAME, PLACES, POSE_CORRECTION, VISIT
from sceneq_tools.errors import UserError
from sceneq_tools.journal_player import JournalPlayer
from sceneq_tools.local_bus import LocalBus, LocalHub

ROBOT, SENSOR = "robot", "camera"
PLAYER = "player"
NODES = ("mapping", "views")


@dataclass(frozen=True, slots=True)
class Merged:
    """What came of it: ``keyframes`` of the other scene are in, ``instances`` before and after.

    ``waiting``: keyframes of its visits that were not placed there and now wait here.
    """

    found: Relocation
    visits: tuple[int, ...]
    keyframes: int
    instances: tuple[int, int]
    troubles: Mapping[str, int]
    waiting: int = 0


@dataclass(frozen=True, slots=True)
class _Other:
    """What the other scene's journal tells: its visits and its places."""

    visits: dict[int, Visit]
    places: list[Place]


def merge(
    scene: SceneFolder, other: SceneFolder, into: Path, params: Mapping[str, Mapping[str, Any]]
) -> Merged:
    """Make ``other`` part of ``scene``, in the folder ``into``: that of ``scene``, or a new one.

    ``params`` of mapping and views, by node. Instances of ``scene`` keep their ids.

    Raises:
        UserError: in use, no overlap, ambiguous, or not all that made ``other`` is kept any more.
        StoreError: files that cannot be used.
    """
    with contextlib.ExitStack() as held:
        held.enter_context(other.locked())
        told = _read(other)
        is_new = into != scene.path
        if is_new:
            with scene.locked():
                shutil.copytree(scene.path, into)
        try:
            return replace(_merge(into, other, told, params), waiting=_hand_over(other, into))
        except BaseException:
            if is_new:
                shutil.rmtree(into, ignore_errors=True)
            raise


def _merge(
    folder: Path, other: SceneFolder, told: _Other, params: Mapping[str, Mapping[str, Any]]
) -> Merged:
    with contextlib.closing(LocalHub()) as hub:
        context = Context(PLAYER, folder.name, ROBOT, SENSOR, folder)
        for name in NODES:
            cls = load("nodes", name)
            node = cls(
                validate(cls.Params, params.get(name, {}), (name,)), replace(context, node=name)
            )
            hub.add(node, replace(context, node=name))
        if hub.counters["store_failed"]:
            raise UserError(
                f"{folder}: cannot be gone on with (was it made with other parameters?)"
            )
        bus = LocalBus(hub, context)
        found = _align(_places(bus), told.places, other.path.name)
        numbers = {
            number: _register(bus, visit, other.path.name, found)
            for number, visit in told.visits.items()
            if visit.T_world_odom is not None
        }
        before = int(hub.reported["mapping"]["instances"])
        player = JournalPlayer(other.entries(), found.T_world_odom, numbers)
        hub.add(player, context)
        while not player.is_done:
            hub.idle(PLAYER)
        after = int(hub.reported["mapping"]["instances"])
        return Merged(
            found,
            tuple(sorted(numbers.values())),
            player.keyframes,
            (before, after),
            {name: count for name, count in sorted(hub.counters.items()) if count},
        )


def _hand_over(other: SceneFolder, into: Path) -> int:
    """Let what the other's visits hold wait in ``into`` too; return how many keyframes that is."""
    handed = [one for one in other.waiting() if not (into / one.path.name).exists()]
    for waiting in handed:
        copy_held(waiting.path, into)
    return sum(waiting.keyframes for waiting in handed)


def _read(other: SceneFolder) -> _Other:
    """Return a scene's visits and places; raise ``UserError`` when its journal is not whole."""
    name = other.path.name
    if other.facts().first != 1:
        told = "how it was made is not kept any more (compacted, or beyond store.max_mb)"
        raise UserError(f"{name}: {told}; it can take others in, but not be taken in")
    visits: dict[int, Visit] = {}
    gazetteer = Gazetteer(GazetteerParams())
    for entry in other.entries():
        if entry.kind == VISITED:
            visit = visit_from_json(json.loads(entry.first))
            visits[visit.number] = visit
        elif entry.kind == CORRECTION:
            gazetteer.correct(correction_of(from_bytes(POSE_CORRECTION, entry.first)))
        elif entry.kind == KEYFRAME:
            frame = frame_from_message(from_bytes(FRAME, entry.first))
            gazetteer.visit(frame)
            if (number := visit_of(frame.seq)) not in visits:
                begins = (seq_of(frame.seq), frame.stamp_ns, fingerprint_of(frame))
                visits[number] = Visit(number, ROBOT, "", *begins, HERE)
    return _Other(visits, list(gazetteer))


def _places(bus: LocalBus) -> list[Place]:
    fetch = Fetch(bus, PLACES, {}, scene=bus.context.scene)
    while not fetch.done:
        fetch.step()
    places = () if fetch.message is None else fetch.message.places
    return [place_from_message(place) for place in places]


def _align(places: list[Place], seen: list[Place], name: str) -> Relocation:
    """Return where the other scene lies; raise ``UserError`` when that cannot be told."""
    relocaliser = Relocaliser(RelocaliserParams())
    relocaliser.learn(places)
    for place in seen:
        relocaliser.see(place)
    found, standing = relocaliser.answer(), relocaliser.standing
    if found is not None:
        return found
    needed = RelocaliserParams().min_keyframes
    counted = (
        f"of {standing.seen} places of {name}, {standing.recognised} look like one of the "
        f"{len(places)} here, {standing.agreeing} agree on where {name} lies ({needed} needed)"
    )
    if standing.agreeing >= needed:
        raise UserError(f"ambiguous: {counted}, {standing.rivals} on somewhere else")
    raise UserError(f"no overlap: {counted}")


def _register(bus: LocalBus, visit: Visit, origin: str, found: Relocation) -> int:
    """Enter a visit of the other scene into this one; return its number here."""
    asked = {
        "robot": visit.robot,
        "origin": visit.origin or origin,
        "seq": visit.first_seq,
        "stamp_ns": visit.first_stamp_ns,
        "fingerprint": visit.fingerprint,
    }
    told = _ask(bus, asked)
    number = int(told["visit"])
    if told["T_world_odom"] is not None:
        return number  # the same recording made both: what it showed is known here
    T_other_odom: Float64 | None = visit.T_world_odom
    assert T_other_odom is not None  # those that wait are not registered
    evidence = f"{found.keyframes} places of {origin} recognised at {found.places}"
    T_world_odom = np.asarray(found.T_world_odom @ T_other_odom)
    _ask(bus, {"visit": number, "T_world_odom": T_world_odom.tolist(), "evidence": evidence})
    return number


def _ask(bus: LocalBus, asked: Mapping[str, Any]) -> Any:
    try:
        replies = bus.ask(VISIT, payload=json_bytes(asked), scene=bus.context.scene)
    except QueryError as error:
        raise UserError(str(error)) from error
    return from_bytes(VISIT, replies[-1].payload)
