"""Segments that somebody else made: one label image per frame in a folder."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import cv2
import numpy as np

from sceneq_core.arrays import Array, UInt16
from sceneq_core.frame import Frame
from sceneq_core.visits import seq_of
from sceneq_nodes._frame_files import lap_length
from sceneq_nodes._image_file import header

NUMBER = re.compile(r"frame-(\d+)\.")


@dataclass(frozen=True, slots=True)
class FilesSegmenterParams:
    """``path``: folder with ``frame-NNNNNN.mask.png``, uint8 or uint16, NNNNNN the frame's seq."""

    path: str

    def __post_init__(self) -> None:
        if not self.path:
            raise ValueError("path must name a folder with frame-NNNNNN.mask.png, got ''")


class FilesSegmenter:
    """Reads the label image with the frame's number.

    When the folder is played in a loop, seq goes on from lap to lap and the numbers start anew.
    """

    Params: ClassVar[type] = FilesSegmenterParams

    def __init__(self, params: FilesSegmenterParams) -> None:
        """Look at the folder; raise ``ValueError`` when it does not exist."""
        self._folder = Path(params.path)
        if not self._folder.is_dir():
            raise ValueError(f"path: no folder {self._folder}")
        found = (NUMBER.match(path.name) for path in self._folder.iterdir())
        self._numbers = sorted({int(match[1]) for match in found if match})

    def segment(self, frame: Frame) -> UInt16:
        """Return the labels uint16 (H, W) of ``frame``, 0 = no segment.

        Raises:
            ValueError: no file, no complete PNG, not grey 8 or 16 bit, or another size.
        """
        path = self._folder / f"frame-{self._number(seq_of(frame.seq)):06d}.mask.png"
        try:
            labels = _labels(path.read_bytes())
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise ValueError(f"{path}: {reason}") from error
        if labels.shape != frame.depth_m.shape:
            raise ValueError(f"{path}: expected (H, W) = {frame.depth_m.shape}, got {labels.shape}")
        return labels

    def _number(self, seq: int) -> int:
        if not self._numbers or seq <= self._numbers[-1]:
            return seq
        first = self._numbers[0]
        return first + (seq - first) % lap_length(self._numbers)


def _labels(data: bytes) -> UInt16:
    what = header(data)
    if what.channels != 1 or what.bits not in (8, 16):
        raise ValueError(f"expected grey 8 or 16 bit, got {what.channels} x {what.bits} bit")
    labels: Array | None = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if labels is None or labels.ndim != 2:
        raise ValueError("does not decode to one channel")
    return labels.astype(np.uint16)
