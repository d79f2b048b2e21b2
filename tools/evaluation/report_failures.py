"""Pictures of the worst answers: what was answered, and what would have been right."""

import base64
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from sceneq_core.arrays import Array, UInt8
from sceneq_core.routing.scene import SceneInstance, SceneSnapshot, ViewRef
from sceneq_tools.evaluation.rendered_truth import instance_image
from sceneq_tools.evaluation.retrieval_asking import Answered
from sceneq_tools.evaluation.retrieval_setup import Setup
from sceneq_tools.evaluation.suite_scene import Asked

Box = tuple[float, float, float, float]

WRONG_BGR, RIGHT_BGR = (48, 48, 214), (72, 150, 36)
LINE_PX = 4
TILE_WIDTH_PX = 400
QUALITY = 82
EACH = 6


@dataclass(frozen=True, slots=True, eq=False)
class Failure:
    """A wrong answer, and how sure (``p``) the encoder was of its first guess."""

    asked: Asked
    answer: Answered
    p: float

    @property
    def answered(self) -> SceneInstance | None:
        """What was answered, unless that there is no such thing."""
        if self.answer.is_not_found or not self.answer.ranked:
            return None
        return _find(self.asked.candidates.snapshot, self.answer.ranked[:1])

    @property
    def wanted(self) -> SceneInstance | None:
        """What would have been right, as the truth saw it; ``None`` = nothing, or it was unseen."""
        return _find(self.asked.scene.true.snapshot, sorted(self.answer.query.targets))


def worst(asked: Iterable[Asked], setup: Setup, count: int = EACH) -> list[Failure]:
    """Return the ``count`` worst wrong answers: claims first, and of these the surest.

    Questions that nothing could have answered right are left out: there the map is at fault.
    """
    failures = [failure for one in asked for failure in _failures(one, setup)]
    return sorted(failures, key=lambda one: (not one.answer.is_found, -one.p))[:count]


def _failures(asked: Asked, setup: Setup) -> Iterable[Failure]:
    for answer in asked.retrieval.answers:
        query = answer.query
        answerable = query.is_absent or asked.right_ids(query)
        if answerable and not asked.is_right(answer):
            snapshot = asked.candidates.snapshot
            first = setup.router.answer(snapshot, setup.router.read(query.text)).answer
            yield Failure(asked, answer, first.confidence.p_max)


def failure_record(failure: Failure) -> dict[str, Any]:
    """Return a failure in values that JSON knows, with its pictures as data URIs."""
    answer, answered = failure.answer, failure.answered
    names = {thing.id: thing.name for thing in failure.asked.scene.questioned.things}
    return {
        "recording": failure.asked.scene.recording.name,
        "candidates": failure.asked.candidates.name,
        "hit_rule": failure.asked.retrieval.hit_rule,
        "question": answer.query.text,
        "bucket": answer.query.bucket,
        "status": answer.status,
        "route": answer.route,
        "p": round(failure.p, 3),
        "answered": answered and f"{answered.instance_id} {answered.label.name}",
        "right": [names.get(target, str(target)) for target in sorted(answer.query.targets)],
        "reason": answer.reason,
        "pictures": [
            {"says": says, "image": data_uri(picture)} for says, picture in pictures(failure)
        ],
    }


def pictures(failure: Failure) -> Iterable[tuple[str, UInt8]]:
    """Yield what there is to see, BGR: the answer's evidence, and the right one's best view.

    Where the right thing shows in the answer's evidence too, it is marked there.
    """
    folder = failure.asked.scene.recording.folder
    if (answered := failure.answered) and (view := _best_view(answered)):
        right = _shown_box(folder, view.seq, sorted(failure.answer.query.targets))
        yield (
            "answered",
            _marked(folder, view.seq, [(right, RIGHT_BGR), (view.box_xyxy, WRONG_BGR)]),
        )
    if (wanted := failure.wanted) and (view := _best_view(wanted)):
        yield "right", _marked(folder, view.seq, [(view.box_xyxy, RIGHT_BGR)])


def data_uri(image_bgr: UInt8, width: int = TILE_WIDTH_PX) -> str:
    """Return a picture, made ``width`` wide, as a JPEG in a data URI."""
    height = round(width * image_bgr.shape[0] / image_bgr.shape[1])
    small = cv2.resize(image_bgr, (width, height), interpolation=cv2.INTER_AREA)
    _, jpeg = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return "data:image/jpeg;base64," + base64.b64encode(jpeg.tobytes()).decode()


def _find(snapshot: SceneSnapshot, ids: Sequence[int]) -> SceneInstance | None:
    rows = [row for one in ids if (row := snapshot.find(one)) is not None]
    return snapshot.instances[rows[0]] if rows else None


def _best_view(instance: SceneInstance) -> ViewRef | None:
    return instance.views[0] if instance.views else None


def _shown_box(folder: Path, seq: int, ids: Sequence[int]) -> Box | None:
    """Return the box of things in a frame, by its instance image; ``None`` = not in it."""
    rows, columns = np.nonzero(np.isin(instance_image(folder, seq), ids))
    if not len(rows):
        return None
    return float(columns.min()), float(rows.min()), float(columns.max()), float(rows.max())


def _marked(
    folder: Path, seq: int, boxes: Iterable[tuple[Box | None, tuple[int, int, int]]]
) -> UInt8:
    image = _frame(folder, seq)
    for box, colour in boxes:
        if box is not None:
            left, top, right, bottom = (round(edge) for edge in box)
            cv2.rectangle(image, (left, top), (right, bottom), colour, LINE_PX)
    return image


def _frame(folder: Path, seq: int) -> UInt8:
    """Return the colour image of a frame, BGR; grey when it cannot be read any more."""
    for path in sorted(folder.glob(f"frame-{seq:06d}.color.*")):
        image: Array | None = cv2.imread(str(path))
        if image is not None:
            return image.astype(np.uint8)
    return np.full((480, 640, 3), 200, np.uint8)
