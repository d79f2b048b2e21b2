"""Questions about a room with their exact answers, and none that is unclear.

Every question is asked after the last frame, about the room as it is then. What it asks for was
seen well; whatever else is there and could be meant counts against it. Several right answers =
any of them is right; none = the right answer is "not found".
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from sceneq_tools.room.room import Room, Thing
from sceneq_tools.room.truth.attributes import Attributes
from sceneq_tools.room.truth.phrases import PURPOSES, content_words, could_mean, names
from sceneq_tools.room.truth.relations import Layout

BUCKETS = ("category", "attribute", "spatial", "affordance", "absent")


@dataclass(frozen=True, slots=True)
class Question:
    """What is asked, and the ids of all right answers.

    Attributes:
        kind: what makes it a question of its bucket, such as ``colour`` or ``next_to``.
        distractors: how many other things a careless reading would take.
        anchor: id of the thing the answer is described by, ``None`` without one.
    """

    text: str
    bucket: str
    targets: tuple[int, ...]
    kind: str
    distractors: int = 0
    anchor: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Survey:
    """A room as it is now, and what a walk through it has shown of it.

    Attributes:
        well: ids of things seen well where they are now.
        attributes: of every thing that is not stuff.
        gone: things that were there once and no longer are.
    """

    room: Room
    well: frozenset[int]
    attributes: dict[int, Attributes]
    gone: tuple[Thing, ...] = ()
    layout: Layout = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "layout", Layout(self.room))

    @property
    def things(self) -> tuple[Thing, ...]:
        """Everything but walls, floor and ceiling, by id."""
        found = (thing for thing in self.room.things if not thing.is_stuff)
        return tuple(sorted(found, key=lambda thing: thing.id))

    @property
    def labels(self) -> tuple[str, ...]:
        """The labels of things seen well, sorted."""
        return tuple(sorted({t.label for t in self.things if t.id in self.well}))

    def meant(self, phrase: str) -> tuple[Thing, ...]:
        """Return everything that somebody who says ``phrase`` could mean, seen or not."""
        return tuple(thing for thing in self.things if could_mean(phrase, thing.category))

    def is_stale(self, phrase: str) -> bool:
        """Tell whether something of that name has gone: a map may not have noticed."""
        return any(could_mean(phrase, thing.category) for thing in self.gone)

    def anchors(self) -> tuple[Thing, ...]:
        """Return the things whose label alone says which one is meant."""
        return tuple(
            thing
            for thing in self.things
            if thing.id in self.well
            and self.meant(thing.label) == (thing,)
            and not self.is_stale(thing.label)
        )


Asker = Callable[[Survey, np.random.Generator], Iterator[Question]]


def questions(
    survey: Survey, rng: np.random.Generator, per_bucket: int = 10
) -> tuple[Question, ...]:
    """Return at most ``per_bucket`` questions of every bucket, those with distractors first."""
    from sceneq_tools.room.truth.absent_questions import ask_absent
    from sceneq_tools.room.truth.attribute_questions import ask_attributes
    from sceneq_tools.room.truth.spatial_questions import ask_spatial

    askers: tuple[Asker, ...] = (
        ask_categories, ask_attributes, ask_spatial, ask_purposes, ask_absent,
    )  # fmt: skip
    return tuple(
        question for ask in askers for question in _chosen(list(ask(survey, rng)), rng, per_bucket)
    )


def ask_categories(survey: Survey, rng: np.random.Generator) -> Iterator[Question]:
    """Ask for things by a name that nothing else could go by: all of that label are right."""
    for label in survey.labels:
        right = tuple(thing for thing in survey.things if thing.label == label)
        clear = [name for name in names(right[0].category) if _is_clear(survey, name, right)]
        if clear:
            text = clear[int(rng.integers(len(clear)))]
            similar = _similar(survey, text) - len(right)
            yield Question(text, "category", _ids(right), "name", max(0, similar))


def ask_purposes(survey: Survey, rng: np.random.Generator) -> Iterator[Question]:
    """Ask for what things are good for: everything that serves is right."""
    del rng  # every purpose has one wording
    for text, verbs in PURPOSES:
        right = tuple(t for t in survey.things if verbs & set(t.category.affordances))
        served = any(verbs & set(thing.category.affordances) for thing in survey.gone)
        if not served and any(thing.id in survey.well for thing in right):
            yield Question(text, "affordance", _ids(right), kind="purpose")


def _is_clear(survey: Survey, name: str, right: tuple[Thing, ...]) -> bool:
    ids = {thing.id for thing in right}
    return not survey.is_stale(name) and all(thing.id in ids for thing in survey.meant(name))


def _similar(survey: Survey, name: str) -> int:
    """Count the things with a word of the name in their own: "coffee maker", "coffee mug"."""
    words = content_words(name)
    return sum(
        any(words & content_words(other) for other in names(thing.category))
        for thing in survey.things
    )


def _ids(things: tuple[Thing, ...]) -> tuple[int, ...]:
    return tuple(thing.id for thing in things)


def _chosen(asked: list[Question], rng: np.random.Generator, count: int) -> tuple[Question, ...]:
    """Take the kinds in turn, in each those with distractors first; every text once."""
    kinds: dict[str, list[Question]] = {}
    for at in rng.permutation(len(asked)):
        kinds.setdefault(asked[at].kind, []).append(asked[at])
    queues = [sorted(kinds[kind], key=lambda q: q.distractors == 0) for kind in sorted(kinds)]
    turns = [queue[i] for i in range(len(asked)) for queue in queues if i < len(queue)]
    unique = {question.text: question for question in reversed(turns)}
    return tuple(q for q in turns if unique[q.text] is q)[:count]
