"""Changing a room: things are moved, removed and added."""

from collections.abc import Callable, Collection
from dataclasses import replace

import numpy as np

from sceneq_tools.room.category import Category
from sceneq_tools.room.layout.compose import PLANS
from sceneq_tools.room.layout.draft import carried_by, drafted, finished, is_rug
from sceneq_tools.room.layout.placement import pose
from sceneq_tools.room.layout.places import BUILT_IN, find_place, known, name_of
from sceneq_tools.room.layout.stock import Stock
from sceneq_tools.room.library import Library
from sceneq_tools.room.room import FLOOR_ID, Room, Thing

Seen = Collection[int] | None
"""Ids of what may be changed, ``None`` = everything."""


def moved(
    room: Room,
    thing_id: int,
    onto: int,
    rng: np.random.Generator,
    near_xy: tuple[float, float] | None = None,
    relation: str = "on",
) -> Room:
    """Return the room with a thing, and what it carries, in another place.

    Args:
        room: as it is.
        thing_id: what is moved.
        onto: id of furniture, of another thing, of the floor, or of a wall for what hangs.
        rng: decides among the free places.
        near_xy: world position that the place should be close to.
        relation: ``on`` (inside where the level is a shelf) or ``under``.

    Raises:
        ValueError: it cannot be moved or there is no free place; says why.
    """
    thing = _movable(room, thing_id)
    riders = tuple(carried_by(room.things, thing_id))
    gone = {thing_id, *(rider.id for rider in riders)}
    if onto in gone:
        raise ValueError(f"{name_of(thing)} cannot be put on itself or on what it carries")
    rest = replace(room, things=tuple(t for t in room.things if t.id not in gone))
    draft = drafted(rest, rng)
    place = find_place(draft, thing, thing.mesh, onto, near_xy, relation, riders)
    T_change = place[0] @ np.linalg.inv(thing.T_world_thing)
    changed = {
        rider.id: replace(rider, T_world_thing=T_change @ rider.T_world_thing) for rider in riders
    }
    changed[thing_id] = replace(thing, T_world_thing=place[0], support=place[1], relation=place[2])
    draft.things = [changed.get(t.id, _uncovered(t, thing_id)) for t in room.things]
    draft.next_id = max(draft.next_id, room.next_id)
    return finished(draft, room.kind, room.seed)


def removed(room: Room, thing_id: int) -> Room:
    """Return the room without a thing and what it carries.

    Raises:
        ValueError: no such thing, or it belongs to the house.
    """
    _movable(room, thing_id)
    gone = {thing_id, *(rider.id for rider in carried_by(room.things, thing_id))}
    draft = drafted(room, np.random.default_rng(0))
    draft.things = [_uncovered(t, thing_id) for t in room.things if t.id not in gone]
    return finished(draft, room.kind, room.seed)


def added(
    room: Room,
    category_or_label: Category | str,
    onto: int,
    library: Library,
    rng: np.random.Generator,
    tint: str | None = None,
    near_xy: tuple[float, float] | None = None,
    relation: str = "on",
) -> Room:
    """Return the room with one more thing, the last of its things.

    Raises:
        ValueError: no such label or tint in the library, or no free place; says why.
    """
    category = _category(library, category_or_label)
    item = Stock(library, rng).item(category, tint)
    draft = drafted(room, rng)
    newcomer = Thing(draft.next_id, category, item.model_id, item.mesh, pose(0, 0), tint=item.tint)
    T_world, support, related = find_place(draft, newcomer, item.mesh, onto, near_xy, relation, ())
    draft.add(item, T_world, support, related)
    return finished(draft, room.kind, room.seed)


def random_changes(
    room: Room,
    library: Library,
    rng: np.random.Generator,
    count: int,
    seen: Seen = None,
) -> tuple[Room, list[str]]:
    """Return the room after some changes to small things, and a sentence on each of them.

    With ``seen`` only things of these ids are moved or removed, and put only on these.
    """
    told: list[str] = []
    for _ in range(20 * count):
        if len(told) == count:
            break
        change = _CHANGES[int(rng.choice(len(_CHANGES), p=_SHARES))]
        try:
            room, sentence = change(room, library, rng, seen)
        except ValueError:
            continue  # It did not fit there; another place or thing is tried.
        told.append(sentence)
    return room, told


def _random_move(room: Room, _: Library, rng: np.random.Generator, seen: Seen) -> tuple[Room, str]:
    thing = _any(_small(room), rng, seen)
    onto = _any(_new_hosts(room, thing), rng, seen)
    room = moved(room, thing.id, onto.id, rng)
    after = room.thing(thing.id)
    return (
        room,
        f"moved {name_of(thing)}, now {after.relation} {name_of(onto)}",
    )


def _random_removal(
    room: Room, _: Library, rng: np.random.Generator, seen: Seen
) -> tuple[Room, str]:
    thing = _any(_small(room), rng, seen)
    return removed(room, thing.id), f"removed {name_of(thing)}"


def _random_addition(
    room: Room, library: Library, rng: np.random.Generator, seen: Seen
) -> tuple[Room, str]:
    onto = _any(_hosts(room), rng, seen)
    small = [category for category in library.categories() if category.role == "top"]
    usual = [category for category in small if _belongs(category, onto, room.kind)]
    category = (usual or small)[int(rng.integers(len(usual or small)))]
    room = added(room, category, onto.id, library, rng)
    new = room.things[-1]
    return room, f"added {name_of(new)}, {new.relation} {name_of(onto)}"


_CHANGES: tuple[Callable[[Room, Library, np.random.Generator, Seen], tuple[Room, str]], ...] = (
    _random_move,
    _random_removal,
    _random_addition,
)
_SHARES = (0.5, 0.25, 0.25)


def _any(things: list[Thing], rng: np.random.Generator, seen: Seen) -> Thing:
    things = [thing for thing in things if seen is None or thing.id in seen]
    if not things:
        raise ValueError("nothing there that could be changed")
    return things[int(rng.integers(len(things)))]


def _small(room: Room) -> list[Thing]:
    return [t for t in room.things if t.category.role in ("top", "floor") and not t.is_stuff]


def _hosts(room: Room) -> list[Thing]:
    """Return the furniture that already carries something, so that what is put there is seen."""
    carrying = {t.support for t in room.things if t.relation in ("on", "in")}
    return [t for t in room.things if t.id in carrying and not t.is_stuff and not is_rug(t)]


def _new_hosts(room: Room, thing: Thing) -> list[Thing]:
    """Return what else may carry a thing: the floor, for what does not belong on a table."""
    if thing.category.role == "floor":
        return [room.thing(FLOOR_ID)]
    return [host for host in _hosts(room) if host.id not in (thing.id, thing.support)]


def _belongs(category: Category, host: Thing, kind: str) -> bool:
    """Tell whether people put such a thing on such a host in that kind of room."""
    return any(
        category.label in small.what and {host.label, host.category.role} & set(small.on)
        for small in PLANS[kind].small
    )


def _category(library: Library, named: Category | str) -> Category:
    if isinstance(named, Category):
        return named
    for category in library.categories():
        if named == category.label or named in category.synonyms:
            return category
    raise ValueError(f"no model of a {named!r} in {library.name}")


def _movable(room: Room, thing_id: int) -> Thing:
    thing = known(room.things, thing_id)
    if thing.is_stuff or thing.category.role in BUILT_IN:
        raise ValueError(f"{name_of(thing)} belongs to the house and stays where it is")
    if is_rug(thing) and any(carried_by(room.things, thing_id)):
        raise ValueError(f"things stand on {name_of(thing)}: move them first")
    return thing


def _uncovered(thing: Thing, gone_id: int) -> Thing:
    """Return a thing as it is when what it stood under is no longer there."""
    if thing.support == gone_id and thing.relation == "under":
        return replace(thing, support=FLOOR_ID, relation="on")
    return thing
