"""The keyframes an answer rests on, side by side with the instance marked."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from sceneq_core.arrays import UInt8
from sceneq_tools.errors import UserError

WIDTH_PX, HEIGHT_PX, CAPTION_PX = 320, 240, 22
MAX_INSTANCES, MAX_VIEWS = 3, 4
BOX_BGR = (40, 40, 235)
PAPER = 255

Picture = Callable[[str], bytes | None]
"""Key of a view, as in an answer, to the JPEG of its keyframe; ``None`` when it is gone."""


def write_evidence(answer: Mapping[str, Any], picture: Picture, path: Path) -> bool:
    """Write one row of views per instance of an answer, the best first; False = there are none.

    Raises:
        UserError: the file cannot be written.
    """
    rows = [_row(instance, picture) for instance in answer.get("instances", ())[:MAX_INSTANCES]]
    if not rows:
        return False
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        written = cv2.imwrite(str(path), np.vstack(rows))
    except cv2.error:  # it does not know the format that the name asks for
        written = False
    if not written:
        raise UserError(f"{path}: the picture could not be written (a name ending in .png?)")
    return True


def _row(instance: Mapping[str, Any], picture: Picture) -> UInt8:
    sheet = np.full((HEIGHT_PX + CAPTION_PX, MAX_VIEWS * WIDTH_PX, 3), PAPER, np.uint8)
    for column, tile in enumerate(_tiles(instance.get("views", ()), picture)):
        left = column * WIDTH_PX
        sheet[CAPTION_PX:, left : left + WIDTH_PX] = tile
    text = f"{instance['id']} {instance.get('label')}   p {instance['p']:.2f}"
    font = cv2.FONT_HERSHEY_SIMPLEX
    cv2.putText(sheet, text, (6, CAPTION_PX - 6), font, 0.5, (0, 0, 0), 1, cv2.LINE_AA)
    return sheet


def _tiles(views: Sequence[Mapping[str, Any]], picture: Picture) -> Iterator[UInt8]:
    for view in views[:MAX_VIEWS]:
        jpeg = picture(view["key"])
        image = None if jpeg is None else cv2.imdecode(np.frombuffer(jpeg, np.uint8), 1)
        if image is not None:
            left, top, right, bottom = (round(edge) for edge in view["box_xyxy"])
            cv2.rectangle(image, (left, top), (right, bottom), BOX_BGR, 3)
            tile = cv2.resize(image, (WIDTH_PX, HEIGHT_PX), interpolation=cv2.INTER_AREA)
            yield tile.astype(np.uint8)
