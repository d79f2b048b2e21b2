"""What people call the things of a room, and which of them they mean."""

import difflib
from collections.abc import Iterable, Mapping

from sceneq_core.ingest.source import RefusedError
from sceneq_tools.room.room import Room, Thing
from sceneq_tools.room.truth.phrases import content_words, names

LISTED = 12


def find(room: Room, said: str, among: Iterable[Thing]) -> Thing:
    """Return the one thing that is meant by its number or its name: ``17``, ``red mug``.

    Raises:
        RefusedError: nothing of that name, or several: they are listed with their numbers.
    """
    things = tuple(among)
    if said.strip().isdigit():
        return _numbered(int(said), things)
    meant = _meant(said, things)
    if not meant:
        raise RefusedError(f"there is no '{said}' that could be meant here", _similar(said, things))
    if len(meant) > 1:
        listed = "; ".join(f"{thing.id} {phrase(room, thing)}" for thing in meant[:LISTED])
        more = f"; and {len(meant) - LISTED} more" if len(meant) > LISTED else ""
        raise RefusedError(f"'{said}' fits {len(meant)} things: {listed}{more}", "say its number")
    return meant[0]


def movable(room: Room) -> tuple[Thing, ...]:
    """Return what is not part of the building."""
    return tuple(thing for thing in room.things if not thing.is_stuff)


def called(thing: Thing) -> str:
    """Return ``red mug``."""
    return f"{thing.tint} {thing.label}" if thing.tint else thing.label


def phrase(room: Room, thing: Thing) -> str:
    """Return ``red mug on the desk``."""
    carrier = support(room, thing)
    return called(thing) + (f" {thing.relation} the {carrier.label}" if carrier else "")


def support(room: Room, thing: Thing) -> Thing | None:
    """Return what carries a thing."""
    return None if thing.support is None else room.thing(thing.support)


def closest(said: str, known: Iterable[str]) -> str:
    """Return a hint that names what was probably meant."""
    candidates: Mapping[str, str] = {name.lower(): name for name in known}
    close = difflib.get_close_matches(said.lower(), list(candidates), n=3, cutoff=0.6)
    if not close:
        return "see: sceneq sim list"
    return "did you mean " + " or ".join(f"'{candidates[name]}'" for name in close) + "?"


def _numbered(number: int, things: tuple[Thing, ...]) -> Thing:
    for thing in things:
        if thing.id == number:
            return thing
    raise RefusedError(
        f"there is no thing {number} that could be meant here", "see: sceneq sim list"
    )


def _meant(said: str, things: tuple[Thing, ...]) -> list[Thing]:
    """Return those whose whole name it is, or else those whose name has all its words."""
    words = content_words(said)
    if not words:
        return []
    whole = [t for t in things if any(words == name for name in _word_sets(t))]
    return whole or [t for t in things if any(words <= name for name in _word_sets(t))]


def _word_sets(thing: Thing) -> list[frozenset[str]]:
    """Return the words of each name, alone and with its colour."""
    plain = [content_words(name) for name in names(thing.category)]
    return plain + [words | {thing.tint} for words in plain if thing.tint]


def _similar(said: str, things: tuple[Thing, ...]) -> str:
    return closest(said, (name for thing in things for name in (thing.label, called(thing))))
