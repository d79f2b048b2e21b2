"""What a recording of a room really shows: instances, boxes per period, relations."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_tools.room.room import Room, Thing
from sceneq_tools.room.truth.attributes import Attributes, attributes
from sceneq_tools.room.truth.boxes import oriented_box, world_box
from sceneq_tools.room.truth.questions import BUCKETS, Question, Survey
from sceneq_tools.room.truth.relations import relations
from sceneq_tools.room.truth.sightings import SeenParams, Sightings

MOVED_M = 1e-4
"""Boxes that differ by less are the same."""

Box = list[list[float]]


@dataclass(frozen=True, slots=True, eq=False)
class Period:
    """The room from frame ``first`` on, and in words what has just changed."""

    first: int
    room: Room
    changes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """A recording's rooms in order, the first from frame 0 on, and what its frames show."""

    periods: tuple[Period, ...]
    sightings: Sightings

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(self.sightings.pixels)

    @property
    def last_room(self) -> Room:
        """The room as it is at the end."""
        return self.periods[-1].room

    def things(self) -> tuple[Thing, ...]:
        """Return everything that was ever there, as it was last, by id."""
        last = {thing.id: thing for period in self.periods for thing in period.room.things}
        return tuple(last[thing_id] for thing_id in sorted(last))

    def names(self) -> dict[int, str]:
        """Return a unique name for every id: its label with the number of its kind."""
        count: dict[str, int] = {}
        names = {}
        for thing in self.things():
            count[thing.label] = count.get(thing.label, 0) + 1
            names[thing.id] = f"{thing.label.replace(' ', '_')}_{count[thing.label]:02d}"
        return names

    def survey(self, params: SeenParams | None = None) -> Survey:
        """Return the room as it is at the end, with what was seen of it as it is."""
        params = params or SeenParams()
        present = {thing.id for thing in self.last_room.things}
        solid = [thing for thing in self.last_room.things if not thing.is_stuff]
        seen_well = (t.id for t in solid if self.sightings.well(t.id, self.since(t.id), params))
        return Survey(
            room=self.last_room,
            well=frozenset(seen_well),
            attributes={thing.id: attributes(thing) for thing in solid},
            gone=tuple(t for t in self.things() if t.id not in present),
        )

    def since(self, thing_id: int) -> int:
        """Return the frame from which a thing is where it is at the end."""
        return self._history(thing_id)[-1][0]

    def instances(self, attribution: Callable[[str], str]) -> dict[str, Any]:
        """Return the content of instances.json; ``attribution`` of a model id is its licence."""
        names = self.names()
        return {
            "room": _room_record(self.last_room),
            "segments": [self._segment(at, names) for at in range(len(self.periods))],
            "instances": [self._instance(t, names, attribution) for t in self.things()],
            "relations": list(self._relations(names)),
        }

    def _history(self, thing_id: int) -> list[tuple[int, Float64 | None]]:
        """Return (first frame, box or ``None`` while it is not there) of every stay."""
        stays: list[tuple[int, Float64 | None]] = []
        for period in self.periods:
            thing = next((t for t in period.room.things if t.id == thing_id), None)
            box = None if thing is None else world_box(thing)
            if not stays or not _same_box(stays[-1][1], box):
                stays.append((period.first, box))
        return stays

    def _segment(self, at: int, names: dict[int, str]) -> dict[str, Any]:
        period = self.periods[at]
        ends = [later.first - 1 for later in self.periods[at + 1 :]] + [self.frames - 1]
        before = self.periods[at - 1].room if at else period.room
        return {
            "name": f"period {at + 1}" if len(self.periods) > 1 else period.room.kind,
            "first": period.first,
            "last": ends[0],
            "edits": {names[i]: edit for i, edit in _edits(before, period.room)},
            "changes": list(period.changes),
        }

    def _instance(
        self, thing: Thing, names: dict[int, str], attribution: Callable[[str], str]
    ) -> dict[str, Any]:
        record = {
            "id": thing.id,
            "name": names[thing.id],
            "label": thing.label,
            "stuff": thing.is_stuff,
            "history": [
                {"from_frame": first, "box": None if box is None else _rounded(box)}
                for first, box in self._history(thing.id)
            ],
            "frames": self.sightings.frames(thing.id),
            "pixels": self.sightings.total(thing.id),
            "most_pixels": self.sightings.most(thing.id),
        }
        return record if thing.is_stuff else record | _details(thing, names, attribution)

    def _relations(self, names: dict[int, str]) -> Iterator[dict[str, Any]]:
        for at, period in enumerate(self.periods):
            segment = self._segment(at, names)
            for relation in relations(period.room):
                record: dict[str, Any] = {
                    "type": relation.kind,
                    "subject": names[relation.subject],
                    "object": names[relation.object],
                }
                if relation.gap_m is not None:
                    record["gap_m"] = relation.gap_m
                if len(self.periods) > 1:
                    record["segment"] = segment["name"]
                yield record


def questions_document(
    scene: str, asked: tuple[Question, ...], names: dict[int, str], frames: int
) -> dict[str, Any]:
    """Return the content of queries.json."""
    return {
        "scene": scene,
        "note": (
            "asked after the last frame; targets are instance names in instances.json; several "
            "targets = any of them is right; [] = nothing in the scene matches, the right answer "
            "is 'not found'"
        ),
        "after_frame": frames - 1,
        "queries": [
            _question_record(q, names) for bucket in BUCKETS for q in asked if q.bucket == bucket
        ],
    }


def _question_record(question: Question, names: dict[int, str]) -> dict[str, Any]:
    record: dict[str, Any] = {
        "text": question.text,
        "bucket": question.bucket,
        "targets": [names[i] for i in question.targets],
        "kind": question.kind,
        "distractors": question.distractors,
    }
    if question.anchor is not None:
        record["anchor"] = names[question.anchor]
    return record


def _room_record(room: Room) -> dict[str, Any]:
    return {"kind": room.kind, "seed": room.seed, "size_m": [round(x, 4) for x in room.size_m]}


def _details(
    thing: Thing, names: dict[int, str], attribution: Callable[[str], str]
) -> dict[str, Any]:
    box = oriented_box(thing)
    return {
        "attributes": _attributes_record(attributes(thing)),
        "synonyms": list(thing.category.synonyms),
        "affordances": list(thing.category.affordances),
        "support": None if thing.support is None else names.get(thing.support),
        "relation": thing.relation,
        "oriented_box": {
            "centre": _rounded(box.centre),
            "size": _rounded(box.size),
            "axes": _rounded(box.axes.T),
        },
        "model": thing.model_id,
        "tint": thing.tint,
        "attribution": attribution(thing.model_id) if thing.model_id else "",
    }


def _attributes_record(found: Attributes) -> dict[str, Any]:
    return {
        "colour": found.colour,
        "colours": dict(found.colour_shares),
        "material": found.material or None,
        "size_m": list(found.size_m),
    }


def _edits(before: Room, after: Room) -> Iterator[tuple[int, list[float] | str | None]]:
    """Yield what happened to which id: [dx, dy, dz, turn in degrees], ``None`` = gone, "new"."""
    old = {thing.id: thing for thing in before.things}
    new = {thing.id: thing for thing in after.things}
    for thing_id in sorted(old.keys() | new.keys()):
        if thing_id not in new:
            yield thing_id, None
        elif thing_id not in old:
            yield thing_id, "new"
        elif not _same_box(world_box(old[thing_id]), world_box(new[thing_id])):
            yield thing_id, _displacement(old[thing_id], new[thing_id])


def _displacement(old: Thing, new: Thing) -> list[float]:
    shift = new.T_world_thing[:3, 3] - old.T_world_thing[:3, 3]
    turn = new.T_world_thing[:3, :3] @ old.T_world_thing[:3, :3].T
    degrees = np.degrees(np.arctan2(turn[1, 0], turn[0, 0]))
    return [*(round(float(x), 4) for x in shift), round(float(degrees), 2)]


def _same_box(a: Float64 | None, b: Float64 | None) -> bool:
    if a is None or b is None:
        return a is b
    return bool(np.abs(a - b).max() < MOVED_M)


def _rounded(values: Float64) -> Any:
    rounded: Any = np.asarray(values).round(4).tolist()
    return rounded
