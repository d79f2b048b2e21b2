"""The frames of a recording as pictures for a reasoner that looks."""

from pathlib import Path

from sceneq_core.arrays import UInt8
from sceneq_core.reasoning.reasoner import Pictures
from sceneq_core.views.jpeg import rgb_from_jpeg
from sceneq_tools.errors import UserError


def pictures_of(recording: Path) -> Pictures:
    """Return a function that reads ``frame-NNNNNN.color.jpg`` of a folder.

    It raises ``UserError`` for a file that is there and no picture.
    """

    def picture(seq: int, timeout_s: float) -> UInt8 | None:
        path = recording / f"frame-{seq:06d}.color.jpg"
        if not path.is_file():
            return None
        try:
            return rgb_from_jpeg(path.read_bytes())
        except ValueError as error:
            raise UserError(f"{path}: {error}", 2) from error

    return picture
