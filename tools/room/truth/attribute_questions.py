"""Questions that a colour, a material or a size decides."""

from collections.abc import Callable, Iterator

import numpy as np

from sceneq_tools.room.room import Thing
from sceneq_tools.room.truth.questions import Question, Survey

UNLIKE_SHARE = 0.25
"""Another thing is not mistaken for a red one when less of it than this could be called red."""
CLEARLY_BIGGER = 1.3
"""Ratio of lengths that is seen at a glance."""
MATERIALS = ("wicker", "leather", "cardboard", "plush", "rubber")
"""Materials that are seen, and that things of other materials do not look like."""
AT_MOST_OF_A_MATERIAL = 3

Length = Callable[[tuple[float, float, float]], float]
SIZES: tuple[tuple[str, Length], ...] = (
    ("tallest", lambda size: size[2]),
    ("biggest", lambda size: float(np.cbrt(size[0] * size[1] * size[2]))),
    ("smallest", lambda size: -float(np.cbrt(size[0] * size[1] * size[2]))),
)


def ask_attributes(survey: Survey, rng: np.random.Generator) -> Iterator[Question]:
    """Ask for one thing among those of its name by what it looks like."""
    del rng  # everything that can be asked is listed; the choice is made later
    for label in survey.labels:
        group = survey.meant(label)
        if not survey.is_stale(label):
            yield from _by_colour(survey, label, group)
            yield from _by_size(survey, label, group)
    yield from _by_material(survey)


def _by_colour(survey: Survey, label: str, group: tuple[Thing, ...]) -> Iterator[Question]:
    for thing in group:
        colour = survey.attributes[thing.id].colour
        others = [other for other in group if other.id != thing.id]
        if (
            colour is None
            or thing.id not in survey.well
            or thing.label != label
            or any(not _unlike(survey, other, colour) for other in others)
        ):
            continue
        yield Question(f"the {colour} {label}", "attribute", (thing.id,), "colour", len(others))


def _unlike(survey: Survey, thing: Thing, colour: str) -> bool:
    return survey.attributes[thing.id].share_like(colour) <= UNLIKE_SHARE


def _by_size(survey: Survey, label: str, group: tuple[Thing, ...]) -> Iterator[Question]:
    """Compare within one label; all of it must be seen well, for size is judged by looking."""
    if len(group) < 2 or any(t.label != label or t.id not in survey.well for t in group):
        return
    for word, length in SIZES:
        ranked = sorted(group, key=lambda t: -length(survey.attributes[t.id].size_m))
        first, second = (length(survey.attributes[t.id].size_m) for t in ranked[:2])
        if max(abs(first), abs(second)) < CLEARLY_BIGGER * min(abs(first), abs(second)):
            continue
        text = f"the {word} {label}"
        yield Question(text, "attribute", (ranked[0].id,), "size", len(group) - 1)


def _by_material(survey: Survey) -> Iterator[Question]:
    for material in MATERIALS:
        right = [t for t in survey.things if survey.attributes[t.id].material == material]
        seen_well = [thing for thing in right if thing.id in survey.well]
        if seen_well and len(right) <= AT_MOST_OF_A_MATERIAL and not _gone(survey, material):
            ids = tuple(thing.id for thing in right)
            yield Question(f"something made of {material}", "attribute", ids, "material")


def _gone(survey: Survey, material: str) -> bool:
    return any(thing.category.material == material for thing in survey.gone)
