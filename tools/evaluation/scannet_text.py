"""ScanNet's text formats: codes of the truth, and lists of predicted masks.

Truth: one integer a line and point, label * 1000 + instance, 0 = unannotated. Predictions: one
line ``mask_path label_id score`` a mask; the path is relative to the file and names a text file
with one integer a point, which is not 0 where the mask is. Points are the vertices of
``*_vh_clean_2.ply``, labels ScanNet200's numbers.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from sceneq_core.arrays import Int64
from sceneq_core.evaluation.annotation import CODE_BASE
from sceneq_core.evaluation.scannet200_ids import LABELS
from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.predictions import PredictedText
from sceneq_tools.evaluation.truth import UNNAMED, Truth
from sceneq_tools.evaluation.vocabulary import Names

FIELDS = ("mask_path", "label_id", "score")

Line = tuple[Path, int, float]


def read_codes(path: Path) -> Truth:
    """Return the truth in a file of codes; it has no coordinates.

    Raises:
        UserError: no such file, or a line that is no code.
    """
    code = read_integers(path)
    if (code < 0).any():
        line = int(np.argmax(code < 0)) + 1
        raise UserError(f"{path}, line {line}: code: expected 0 or more, got {code[line - 1]}", 2)
    return truth_of_codes(code // CODE_BASE, code % CODE_BASE, str(path))


def truth_of_codes(label: Int64, number: Int64, source: str) -> Truth:
    """Return the truth of ScanNet200 labels (N,) and instance numbers (N,)."""
    labels, name = np.unique(label, return_inverse=True)
    names = (UNNAMED, *(names_of_label(int(one)) for one in labels))
    return Truth(None, name.astype(np.int64) + 1, number, names, source)


def names_of_label(number: int) -> Names:
    """Return what ScanNet200 calls a label number; ``()`` when it does not know it."""
    return (LABELS[number],) if number in LABELS else UNNAMED


def read_predicted_text(path: Path) -> PredictedText:
    """Return the masks that a prediction file lists.

    Raises:
        UserError: a file that is missing, a line that is malformed, or masks of unequal length.
    """
    lines = [_parsed(path, n, text) for n, text in _numbered_lines(path)]
    masks = [read_integers(mask_path) for mask_path, _, _ in lines]
    _need_equal_lengths(path, lines, [len(mask) for mask in masks])
    points = [np.flatnonzero(mask) for mask in masks]
    return PredictedText(
        source=str(path),
        count=len(masks[0]) if masks else 0,
        mask=np.repeat(np.arange(len(masks)), [len(point) for point in points]),
        point=np.concatenate([np.zeros(0, np.int64), *points]),
        names=tuple(names_of_label(label) for _, label, _ in lines),
        score=np.array([score for _, _, score in lines], np.float64),
    )


def read_integers(path: Path) -> Int64:
    """Return the integers of a text file, one a line.

    Raises:
        UserError: no such file, or a line that is no integer.
    """
    words = read_text(path).split()
    try:
        return np.array(words, dtype=np.int64)
    except (ValueError, OverflowError) as error:
        line = next(n for n, word in enumerate(words, 1) if not _is_integer(word))
        raise UserError(
            f"{path}, line {line}: not an integer: {words[line - 1]!r:.40}", 2
        ) from error


def read_text(path: Path) -> str:
    """Return the content of a text file; ``UserError`` names one that cannot be read."""
    try:
        return path.read_text()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not a text file"
        raise UserError(f"{path}: {reason}", 2) from error


def _numbered_lines(path: Path) -> list[tuple[int, str]]:
    lines = enumerate(read_text(path).splitlines(), 1)
    return [(number, line) for number, line in lines if line.strip()]


def _parsed(path: Path, number: int, text: str) -> Line:
    words = text.split()
    where = f"{path}, line {number}"
    if len(words) != len(FIELDS):
        raise UserError(f"{where}: expected '{' '.join(FIELDS)}', got {text.strip()!r:.80}", 2)
    try:
        label = int(words[1])
    except ValueError as error:
        raise UserError(f"{where}: label_id: not an integer: {words[1]!r:.40}", 2) from error
    return path.parent / words[0], label, _score(where, words[2])


def _score(where: str, word: str) -> float:
    try:
        score = float(word)
    except ValueError as error:
        raise UserError(f"{where}: score: not a number: {word!r:.40}", 2) from error
    if not np.isfinite(score):
        raise UserError(f"{where}: score: not finite: {word!r:.40}", 2)
    return score


def _need_equal_lengths(path: Path, lines: Sequence[Line], lengths: Sequence[int]) -> None:
    for (mask_path, _, _), length in zip(lines, lengths, strict=True):
        if length != lengths[0]:
            first = f"{lines[0][0].name} has {lengths[0]}"
            raise UserError(f"{path}: {mask_path.name} has {length} points, {first}", 2)


def _is_integer(word: str) -> bool:
    try:
        return -(2**63) <= int(word) < 2**63
    except ValueError:
        return False
