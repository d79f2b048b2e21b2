"""What to ask about a recording, and whether an answer is right, where its folder knows."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_tools.errors import UserError

QUESTIONS = ("chair", "white mug", "the monitor on the table", "something to sit on", "bicycle")
COUNT = 6
CHOICE = "demo.txt"
NEAR_IOU = 0.05
RIGHT_IOU = 0.25
"""Overlap of the answered with the true box from which on they are the same thing (AP25)."""


Thing = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Question:
    """What is asked; ``targets`` names all right answers, ``None`` = nobody knows."""

    text: str
    bucket: str = ""
    targets: tuple[str, ...] | None = None


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether an answer is right, and why; ``right`` is ``None`` when nobody knows."""

    right: bool | None
    words: str

    @property
    def tone(self) -> str:
        """How it is coloured on a terminal."""
        return "" if self.right is None else ("good" if self.right else "warn")


def questions_of(folder: Path, texts: Sequence[str] = ()) -> list[Question]:
    """Return ``texts`` as questions, or six of the folder's own, or some that fit anywhere.

    The folder's own are the lines of its demo.txt (# = remark), or six of its queries.json.

    Raises:
        UserError: queries.json is not what it should be.
    """
    known = _known(folder / "queries.json")
    if texts := texts or _chosen(folder / CHOICE):
        by_text = {question.text: question for question in known}
        return [by_text.get(text, Question(text)) for text in texts]
    return spread(known, COUNT) or [Question(text) for text in QUESTIONS]


def spread(known: Sequence[Question], count: int) -> list[Question]:
    """Return up to ``count`` questions: of each bucket in turn one about something new."""
    buckets: dict[str, list[Question]] = {}
    for question in known:
        buckets.setdefault(question.bucket, []).append(question)
    chosen: list[Question] = []
    while len(chosen) < count and any(buckets.values()):
        for left in filter(None, buckets.values()):
            asked = {target for question in chosen for target in question.targets or ()}
            fresh = [q for q in left if not asked & set(q.targets or ())]
            chosen.append((fresh or left)[0])
            left.remove(chosen[-1])
    return sorted(chosen[:count], key=lambda question: list(buckets).index(question.bucket))


class Truth:
    """The true boxes of a recording, as far as its folder has an instances.json.

    Raises:
        UserError: it is not what it should be.
    """

    def __init__(self, folder: Path) -> None:
        path = folder / "instances.json"
        try:
            document = json.loads(path.read_text()) if path.is_file() else {"instances": []}
            self._things = [thing for thing in document["instances"] if not thing["stuff"]]
        except (ValueError, KeyError, TypeError) as error:
            raise UserError(f"{path}: cannot be read: {error!r}", 2) from error

    def verdict(self, question: Question, answer: Mapping[str, Any], frame: int) -> Verdict:
        """Say whether the best instance of an answer is right at ``frame``."""
        if question.targets is None or not self._things:
            return Verdict(None, "nobody knows (no truth in the folder)")
        found = answer.get("status") != "not_found" and answer.get("instances")
        if not found:
            return _of_nothing(question)
        if not question.targets:
            return Verdict(False, "wrong: there is no such thing")
        thing, overlap = self._nearest(answer["instances"][0], frame)
        if _is_right(question, thing, overlap):
            return Verdict(True, f"right: the {thing['label']}, boxes overlap by {overlap:.2f}")
        rank = self._rank_of_right(question, answer, frame)
        hint = f"; the right one is number {rank}" if rank else ""
        if overlap >= RIGHT_IOU:
            return Verdict(False, f"wrong: that is the {thing['label']}{hint}")
        near = f" (overlap with the {thing['label']}: {overlap:.2f})" if overlap >= NEAR_IOU else ""
        return Verdict(False, f"wrong: a piece of nothing in particular{near}{hint}")

    def _rank_of_right(self, question: Question, answer: Mapping[str, Any], frame: int) -> int:
        """Return the place of the first right instance, 0 = none is."""
        for rank, instance in enumerate(answer["instances"], 1):
            if _is_right(question, *self._nearest(instance, frame)):
                return rank
        return 0

    def _nearest(self, instance: Mapping[str, Any], frame: int) -> tuple[Thing, float]:
        """Return the true thing that an instance overlaps most, and how much."""
        box = instance["box_aabb"]
        answered = np.array([box["min"], box["max"]], np.float64)
        boxes = [_box_at(thing, frame) for thing in self._things]
        overlaps = [0.0 if true is None else iou(answered, true) for true in boxes]
        best = int(np.argmax(overlaps))
        return self._things[best], overlaps[best]


def _is_right(question: Question, thing: Thing, overlap: float) -> bool:
    """Targets are names, or ids as text."""
    named = {str(thing["name"]), str(thing["id"])} & set(question.targets or ())
    return bool(named) and overlap >= RIGHT_IOU


def iou(a: Float64, b: Float64) -> float:
    """Return intersection over union of two boxes (2, 3), minimum and maximum, metres."""
    shared = np.minimum(a[1], b[1]) - np.maximum(a[0], b[0])
    if (shared <= 0).any():
        return 0.0
    volume = float(np.prod(shared))
    return volume / (float(np.prod(a[1] - a[0]) + np.prod(b[1] - b[0])) - volume)


def _of_nothing(question: Question) -> Verdict:
    if question.targets:
        return Verdict(False, "wrong: it is there")
    return Verdict(True, "rightly not found")


def _box_at(thing: Thing, frame: int) -> Float64 | None:
    """Return the box (2, 3) of a thing at ``frame``, ``None`` when it is not there."""
    boxes = [period["box"] for period in thing["history"] if period["from_frame"] <= frame]
    return np.array(boxes[-1], np.float64) if boxes and boxes[-1] is not None else None


def remark(folder: Path) -> str:
    """Return what the folder's demo.txt says of its choice of questions, "" without one."""
    return " ".join(line.lstrip("# ") for line in _lines(folder / CHOICE) if line.startswith("#"))


def _chosen(path: Path) -> list[str]:
    return [line for line in _lines(path) if not line.startswith("#")]


def _lines(path: Path) -> list[str]:
    lines = path.read_text().splitlines() if path.is_file() else []
    return [line for line in lines if line]


def _known(path: Path) -> list[Question]:
    if not path.is_file():
        return []
    try:
        queries = json.loads(path.read_text())["queries"]
        return [Question(q["text"], q["bucket"], tuple(map(str, q["targets"]))) for q in queries]
    except (ValueError, KeyError, TypeError) as error:
        raise UserError(f"{path}: cannot be read: {error!r}", 2) from error
