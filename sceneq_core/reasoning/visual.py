"""From a problem to a question about pictures, and from its replies to a verdict.

The paper's selective reasoning: K candidates as a multiple choice, one box per full view, majority
vote. What asks the model, and how long that may take, is not decided here.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import UInt8
from sceneq_core.checks import need_at_least, need_between, need_within
from sceneq_core.reasoning.answer_parser import UnusableReplyError, read_choice
from sceneq_core.reasoning.multiple_choice import NONE, VisualQuestion, which_box, which_label
from sceneq_core.reasoning.numbered_boxes import draw_boxes, is_visible
from sceneq_core.reasoning.reasoner import Box, Candidate, LabelProblem, Views
from sceneq_core.reasoning.vote import instance_shares, label_shares, ranked


@dataclass(frozen=True, slots=True)
class VisualParams:
    """How things are shown and votes are weighed.

    ``max_views``: pictures in one text-to-instance question; every picture costs some hundred
    tokens. ``label_views``: views of an instance that are asked about when it is named, each in
    its own call. ``longest_px``: longer side of a picture that is sent. ``prior_votes``: weight of
    the encoder beside one vote of the model; below 1, so that it decides ties only.
    """

    max_views: int = 4
    label_views: int = 3
    longest_px: int = 1024
    prior_votes: float = 0.5

    def __post_init__(self) -> None:
        need_within(self, 1, 16, "max_views", "label_views")
        need_at_least(self, 64, "longest_px")
        need_between(self, 0, 1, "prior_votes")


@dataclass(frozen=True, slots=True)
class Shown:
    """A question and, for every box number from 1, the row of the candidate it marks."""

    question: VisualQuestion
    rows: tuple[int, ...]


def show_candidates(
    text: str,
    candidates: Sequence[Candidate],
    pictures: Mapping[int, UInt8],
    params: VisualParams,
) -> Shown:
    """Return the question, with every candidate that the keyframes (by seq) show as a box.

    Raises:
        ValueError: no box of any candidate lies in a picture.
    """
    boxes = {
        seq: _boxes_in(seq, rgb, [c.views for c in candidates], params)
        for seq, rgb in pictures.items()
    }
    rows = sorted({row for of_seq in boxes.values() for row in of_seq})
    if not rows:
        raise ValueError("views: no candidate has a box in its keyframe")
    number = {row: i for i, row in enumerate(rows, start=1)}
    marked = [
        draw_boxes(rgb, {number[row]: box for row, box in boxes[seq].items()}, params.longest_px)
        for seq, rgb in pictures.items()
    ]
    return Shown(which_box(text, marked, len(rows)), tuple(rows))


def show_thing(
    problem: LabelProblem, pictures: Mapping[int, UInt8], params: VisualParams
) -> list[VisualQuestion]:
    """Return the same question once for every keyframe (by seq), the thing in its only box.

    Raises:
        ValueError: no labels to choose from, or no box that lies in its keyframe.
    """
    if not problem.labels:
        raise ValueError("labels: none to choose from")
    names = [name for name, _ in problem.labels]
    boxes = {seq: _boxes_in(seq, rgb, [problem.views], params) for seq, rgb in pictures.items()}
    questions = [
        which_label(names, draw_boxes(rgb, {1: boxes[seq][0]}, params.longest_px))
        for seq, rgb in pictures.items()
        if boxes[seq]
    ]
    if not questions:
        raise ValueError("views: no box of the instance lies in its keyframe")
    return questions


def instance_ranking(
    shown: Shown,
    candidates: Sequence[Candidate],
    choices: Sequence[str],
    params: VisualParams,
) -> tuple[tuple[int, float], ...]:
    """Return ids with probabilities, best first, after ``choices`` (keys) were made.

    Nothing when "none of them" is most probable.
    """
    votes = [None if key == NONE else shown.rows[int(key) - 1] for key in choices]
    prior = np.array([c.p for c in candidates], np.float64)
    seen = [row in shown.rows for row in range(len(candidates))]
    shares = instance_shares(votes, prior, seen, params.prior_votes)
    order = ranked(shares)
    if order[0] == len(candidates):
        return ()
    return tuple(
        (candidates[row].instance_id, float(shares[row])) for row in order if row < len(candidates)
    )


def label_ranking(
    problem: LabelProblem, choices: Sequence[str], params: VisualParams
) -> tuple[tuple[str, float], ...]:
    """Return labels with probabilities, best first, after ``choices`` (keys) were made."""
    prior = np.array([p for _, p in problem.labels], np.float64)
    shares = label_shares([int(key) - 1 for key in choices], prior, params.prior_votes)
    return tuple((problem.labels[row][0], float(shares[row])) for row in ranked(shares))


def read_choices(question: VisualQuestion, replies: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the keys that were chosen, and for every other reply what is wrong with it."""
    choices, problems = [], []
    for reply in replies:
        try:
            choices.append(read_choice(reply, question.keys, question.options))
        except UnusableReplyError as error:
            problems.append(str(error))
    return choices, problems


def _boxes_in(seq: int, rgb: UInt8, views: Sequence[Views], params: VisualParams) -> dict[int, Box]:
    """Return the boxes of one keyframe by row, those that can be seen when it is sent."""
    found = {}
    for row, of_thing in enumerate(views):
        box = next((box for at, box in of_thing if at == seq), None)
        if box is not None and is_visible(box, rgb, params.longest_px):
            found[row] = box
    return found
