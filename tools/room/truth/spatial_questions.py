"""Questions that the place of a thing decides, each with one answer and a margin."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from sceneq_core.checks import need_positive
from sceneq_tools.room.room import Thing
from sceneq_tools.room.truth.boxes import gap
from sceneq_tools.room.truth.questions import Question, Survey
from sceneq_tools.room.truth.relations import RelationParams, is_above, is_beside, is_under


@dataclass(frozen=True, slots=True)
class MarginParams:
    """How much clearer than the others an answer must be.

    Attributes:
        beside_m: another candidate is at least so far from the anchor when one is next to it.
        loosely_m: another candidate may not even nearly be above or under, by so much more reach.
        nearest_m: the nearest is at least so much nearer than the second.
        nearest_ratio: and so many times.
        reach_m: further away than this nobody says "closest to".
        landmark: the anchor is at least so long as a share of the thing it helps to find: nobody
            looks for a chair by the bottle beside it.
    """

    beside_m: float = 0.6
    loosely_m: float = 0.5
    nearest_m: float = 0.4
    nearest_ratio: float = 1.5
    reach_m: float = 1.5
    landmark: float = 0.5

    def __post_init__(self) -> None:
        need_positive(self, *self.__dataclass_fields__)


RELATIONS = RelationParams()
MARGINS = MarginParams()
WORDS = {"on": "on", "in": "in", "under": "under", "above": "above", "next_to": "next to"}


def ask_spatial(survey: Survey, rng: np.random.Generator) -> Iterator[Question]:
    """Ask for one thing by where it is to a thing that its own label makes clear."""
    del rng  # everything that can be asked is listed; the choice is made later
    anchors = survey.anchors()
    for label in survey.labels:
        group = survey.meant(label)
        if survey.is_stale(label):
            continue
        longest = max(max(survey.attributes[thing.id].size_m) for thing in group)
        for anchor in anchors:
            is_landmark = max(survey.attributes[anchor.id].size_m) >= MARGINS.landmark * longest
            if is_landmark and all(thing.id != anchor.id for thing in group):
                yield from _about(survey, label, group, anchor)


def _about(
    survey: Survey, label: str, group: tuple[Thing, ...], anchor: Thing
) -> Iterator[Question]:
    for kind in WORDS:
        target = _only(survey, kind, group, anchor)
        if target is not None and _may_be_asked(survey, label, target):
            text = f"the {label} {WORDS[kind]} the {anchor.label}"
            yield _question(text, target, kind, group, anchor)
    target = _nearest(survey, group, anchor)
    if target is not None and _may_be_asked(survey, label, target):
        text = f"the {label} closest to the {anchor.label}"
        yield _question(text, target, "nearest", group, anchor)


def _question(
    text: str, target: Thing, kind: str, group: tuple[Thing, ...], anchor: Thing
) -> Question:
    return Question(text, "spatial", (target.id,), kind, len(group) - 1, anchor.id)


def _may_be_asked(survey: Survey, label: str, target: Thing) -> bool:
    return target.label == label and target.id in survey.well


def _only(survey: Survey, kind: str, group: tuple[Thing, ...], anchor: Thing) -> Thing | None:
    """Return the thing that stands so to the anchor, if it is the only one by a margin."""
    right = [thing for thing in group if _holds(survey, kind, thing, anchor)]
    nearly = [thing for thing in group if _nearly(survey, kind, thing, anchor)]
    return right[0] if len(right) == 1 and nearly == right else None


def _holds(survey: Survey, kind: str, thing: Thing, anchor: Thing) -> bool:
    layout = survey.layout
    if kind in ("on", "in"):
        return thing.support == anchor.id and thing.relation == kind
    if kind in ("under", "above") and _share_furniture(survey, thing, anchor):
        return False
    if kind == "under":
        return is_under(layout, thing.id, anchor.id, RELATIONS)
    if kind == "above":
        return is_above(layout, thing.id, anchor.id, RELATIONS)
    return is_beside(layout, thing.id, anchor.id, RELATIONS)


def _share_furniture(survey: Survey, a: Thing, b: Thing) -> bool:
    """Tell whether both stand in one bookcase: nobody says that a vase is under a book there."""
    layout = survey.layout
    shared = set(layout.carriers(a.id)) & set(layout.carriers(b.id))
    carriers = [layout.things[i] for i in shared]
    return any(not (thing.is_stuff or thing.category.role == "rug") for thing in carriers)


def _nearly(survey: Survey, kind: str, thing: Thing, anchor: Thing) -> bool:
    """Tell whether somebody could say so of a thing, by a generous reading."""
    layout = survey.layout
    mine, theirs = layout.outlines[thing.id], layout.outlines[anchor.id]
    if kind in ("on", "in"):
        return anchor.id in layout.carriers(thing.id)
    apart = gap(mine, theirs)
    if kind == "next_to":
        return apart < MARGINS.beside_m and not layout.carried(thing.id, anchor.id)
    level = np.abs(mine.centre - theirs.centre) - np.ptp(theirs.corners, axis=0) / 2
    over = bool((level <= MARGINS.loosely_m).all())
    if kind == "under":
        return over and mine.high_m <= theirs.high_m and mine.low_m < theirs.low_m + 0.05
    return over and mine.low_m >= theirs.high_m - MARGINS.loosely_m / 2


def _nearest(survey: Survey, group: tuple[Thing, ...], anchor: Thing) -> Thing | None:
    """Return the nearest of several when both gaps and distances of middles agree on it."""
    if len(group) < 2 or any(survey.layout.carried(t.id, anchor.id) for t in group):
        return None
    gaps = sorted((_gap(survey, t, anchor), t.id) for t in group)
    middles = sorted((_middles(survey, t, anchor), t.id) for t in group)
    if gaps[0][1] != middles[0][1] or gaps[0][0] > MARGINS.reach_m:
        return None
    if not (_clear(gaps[0][0], gaps[1][0]) and _clear(middles[0][0], middles[1][0])):
        return None
    return next(thing for thing in group if thing.id == gaps[0][1])


def _clear(first_m: float, second_m: float) -> bool:
    return second_m - first_m >= MARGINS.nearest_m and second_m >= MARGINS.nearest_ratio * first_m


def _gap(survey: Survey, a: Thing, b: Thing) -> float:
    return gap(survey.layout.outlines[a.id], survey.layout.outlines[b.id])


def _middles(survey: Survey, a: Thing, b: Thing) -> float:
    mine, theirs = survey.layout.outlines[a.id], survey.layout.outlines[b.id]
    up = (mine.low_m + mine.high_m - theirs.low_m - theirs.high_m) / 2
    return float(np.hypot(np.linalg.norm(mine.centre - theirs.centre), up))
