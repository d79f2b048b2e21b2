"""Questions for what is not there: the right answer is "not found"."""

from collections.abc import Iterator

import numpy as np

from sceneq_tools.room.room import Thing
from sceneq_tools.room.truth.colour_names import CONFUSED
from sceneq_tools.room.truth.phrases import ABSENT, content_words, could_mean, head, names
from sceneq_tools.room.truth.questions import Question, Survey

TELLING = ("red", "yellow", "green", "blue", "purple", "orange", "pink")
"""Colours that nobody says of a thing that is not so."""
NOTHING_OF_IT = 0.08
"""The share of a surface up to which a colour is a detail."""
COLOURED_SHARE = 0.2
"""So many of the questions are for things that are there, but not in that colour."""


def ask_absent(survey: Survey, rng: np.random.Generator) -> Iterator[Question]:
    """Ask for things of which nothing in the room could be meant, and for missing colours."""
    for name in ABSENT:
        if not any(_resembles(name, thing) for thing in (*survey.things, *survey.gone)):
            yield Question(name, "absent", (), "name")
    coloured = [question for label in survey.labels for question in _wrong_colour(survey, label)]
    keep = max(1, round(COLOURED_SHARE * 10))
    for at in rng.permutation(len(coloured))[:keep]:
        yield coloured[at]


def _resembles(name: str, thing: Thing) -> bool:
    """Tell whether a name shares its head or its meaning with a thing of the room."""
    called = names(thing.category)
    return could_mean(name, thing.category) or any(
        head(name) in content_words(other) or head(other) in content_words(name) for other in called
    )


def _wrong_colour(survey: Survey, label: str) -> Iterator[Question]:
    """Ask for a colour that no thing of that name has, when the colours of all are known."""
    group = survey.meant(label)
    if survey.is_stale(label) or any(survey.attributes[t.id].colour is None for t in group):
        return
    for colour in TELLING:
        shares = [survey.attributes[thing.id].share_like(colour) for thing in group]
        own = {survey.attributes[thing.id].colour for thing in group}
        if max(shares) <= NOTHING_OF_IT and not own & CONFUSED[colour]:
            yield Question(f"{colour} {label}", "absent", (), "colour", distractors=len(group))
