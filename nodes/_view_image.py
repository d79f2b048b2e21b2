"""Answers for the picture of a keyframe: ``?seq=120`` and, if wanted, ``;box=10,20,200,220``."""

from collections.abc import Callable, Mapping

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_core.views.jpeg import with_box
from sceneq_nodes._bus import QueryError, Reply, Request
from sceneq_schemas.topics import VIEW_IMAGE

HINT = "try ?seq=120 or ?seq=120;box=10,20,200,220"


def answer_image(request: Request, image: Callable[[int], bytes | None]) -> Reply | None:
    """Return the JPEG that ``request`` names; nothing to a wildcard that names none.

    Raises:
        QueryError: ``bad_request`` for parameters that are no numbers, ``not_found`` when the
            keyframe is not, or no longer, in the archive.
    """
    parameters = request.parameters
    if request.wildcard and "seq" not in parameters:
        return None
    seq, box_xyxy = _parse(parameters)
    jpeg = image(seq)
    if jpeg is None:
        raise QueryError("not_found", f"no image of keyframe {seq}", "views name those there are")
    return Reply(jpeg if box_xyxy is None else with_box(jpeg, box_xyxy), VIEW_IMAGE.encoding)


def _parse(parameters: Mapping[str, str]) -> tuple[int, Float32 | None]:
    try:
        seq = _whole_number(parameters["seq"])
        return seq, _box(parameters["box"]) if "box" in parameters else None
    except KeyError as error:
        raise QueryError("bad_request", "the parameter seq is missing", HINT) from error
    except ValueError as error:
        raise QueryError("bad_request", str(error), HINT) from error


def _whole_number(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= 18):
        raise ValueError(f"seq: expected a whole number, got {text!r:.60}")
    return int(text)


def _box(text: str) -> Float32:
    box_xyxy = np.array([float(number) for number in text.split(",")], np.float32)
    if box_xyxy.shape != (4,) or not np.isfinite(box_xyxy).all():
        raise ValueError(f"box {text!r:.60} is not four numbers")
    return box_xyxy
