"""The room behind the simulated camera, and what may be done to it."""

import threading
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from sceneq_core.ingest.source import RefusedError
from sceneq_tools.room.layout.edits import added, moved, removed
from sceneq_tools.room.library import Library
from sceneq_tools.room.models.tints import TINTS
from sceneq_tools.room.room import Room, Thing
from sceneq_tools.room.truth.boxes import world_box
from sceneq_tools.sim.names import called, closest, find, movable, phrase, support

Json = dict[str, Any]


class World:
    """One room that changes; edits come one after the other, from any thread.

    Args:
        on_change: called with the new room before an edit returns.
    """

    def __init__(self, room: Room, library: Library, on_change: Callable[[Room], None]) -> None:
        self._room = room
        self._library = library
        self._on_change = on_change
        self._editing = threading.Lock()
        self._edits = 0

    @property
    def room(self) -> Room:
        """The room as it is now."""
        return self._room

    def listed(self) -> Json:
        """Return every thing with its place."""
        room = self._room
        things = [described(room, thing) for thing in movable(room)]
        return {"room": room.kind, "seed": room.seed, "edits": self._edits, "things": things}

    def move(self, arguments: Mapping[str, str]) -> Json:
        """Put ``thing`` onto ``onto``, with all that stands on it.

        Raises:
            RefusedError: no such thing, or no place for it there.
        """
        with self._editing:
            room = self._room
            thing = find(room, need(arguments, "thing"), movable(room))
            onto = find(room, need(arguments, "onto"), room.things)
            if onto.id == thing.id:
                raise RefusedError(f"the {called(thing)} cannot stand on itself")
            changed = _fitting(lambda: moved(room, thing.id, onto.id, self._rng()))
            return self._done(changed, changed.thing(thing.id), "moved", phrase(room, thing))

    def remove(self, arguments: Mapping[str, str]) -> Json:
        """Take ``thing`` away, with all that stands on it.

        Raises:
            RefusedError: no such thing.
        """
        with self._editing:
            room = self._room
            thing = find(room, need(arguments, "thing"), movable(room))
            changed = _fitting(lambda: removed(room, thing.id))
            gone = [t for t in room.things if t.id not in {left.id for left in changed.things}]
            self._change(changed)
            return {"verb": "removed", "was": phrase(room, thing), "gone": [t.id for t in gone]}

    def add(self, arguments: Mapping[str, str]) -> Json:
        """Put a new thing called ``thing`` onto ``onto``, painted in ``colour`` when given.

        Raises:
            RefusedError: no such model, no such colour, or no place for it there.
        """
        with self._editing:
            room = self._room
            label = self._label(need(arguments, "thing"))
            onto = find(room, need(arguments, "onto"), room.things)
            tint = _tint(arguments.get("colour") or arguments.get("color"))
            changed = _fitting(
                lambda: added(room, label, onto.id, self._library, self._rng(), tint=tint)
            )
            return self._done(changed, changed.things[-1], "added", "")

    def _done(self, changed: Room, thing: Thing, verb: str, was: str) -> Json:
        self._change(changed)
        return {"verb": verb, "was": was, **described(changed, thing)}

    def _change(self, room: Room) -> None:
        self._on_change(room)
        self._room = room
        self._edits += 1

    def _rng(self) -> np.random.Generator:
        return np.random.default_rng((self._room.seed, self._edits))

    def _label(self, said: str) -> str:
        """Return the library's name for what somebody wants to add."""
        categories = self._library.categories()
        for category in categories:
            if said.lower() in (name.lower() for name in (category.label, *category.synonyms)):
                return category.label
        ending = [c.label for c in categories if c.label.lower().split()[-1] == said.lower()]
        if len(ending) == 1:
            return ending[0]
        hint = closest(said, ending or (category.label for category in categories))
        raise RefusedError(f"there is no model of a '{said}'", hint)


def described(room: Room, thing: Thing) -> Json:
    """Return what a thing is called and where it is, metres in the scene's frame."""
    low, high = world_box(thing)
    carrier = support(room, thing)
    return {
        "id": thing.id,
        "label": thing.label,
        "colour": thing.tint,
        "relation": thing.relation,
        "on": carrier.label if carrier else None,
        "on_id": thing.support,
        "centre_m": [round(float(v), 3) for v in (low + high) / 2],
        "size_m": [round(float(v), 3) for v in high - low],
    }


def need(arguments: Mapping[str, str], name: str) -> str:
    """Return an argument; raise ``RefusedError`` when it is missing."""
    said = arguments.get(name, "").strip()
    if not said:
        raise RefusedError(f"'{name}' is missing", f"{name}=NAME or {name}=NUMBER")
    return said


def _tint(said: str | None) -> str | None:
    if said and said.lower() not in TINTS:
        raise RefusedError(f"there is no paint '{said}'", f"known: {', '.join(TINTS)}")
    return said.lower() if said else None


def _fitting(edit: Callable[[], Room]) -> Room:
    try:
        return edit()
    except ValueError as error:
        raise RefusedError(str(error)) from error
