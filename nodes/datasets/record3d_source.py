"""A recording of the iPhone and iPad app Record3D, exported as ``.r3d``, as a source.

Colour has three to eight times the resolution of the LiDAR's depth. It is shrunk to
``color_side_px``, which is enough to recognise things; the depth is registered to that.
"""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import ClassVar

import numpy as np

from sceneq_core.arrays import UInt16
from sceneq_nodes._recorded_source import RecordedParams, RecordedSource, Recording, Size
from sceneq_nodes._resized import decode_resized, resized
from sceneq_nodes.datasets.record3d_file import Record3dFile


@dataclass(frozen=True, slots=True)
class Record3dParams(RecordedParams):
    """``path`` of the .r3d file; ``color_side_px``: the longer side of colour images, at most.

    ``min_confidence`` of a depth: 0 = all, 1 = medium and high, 2 = high.
    """

    color_side_px: int = 640
    min_confidence: int = 1

    def __post_init__(self) -> None:
        RecordedParams.__post_init__(self)
        if self.color_side_px < 1:
            raise ValueError(f"color_side_px: expected 1 or more, got {self.color_side_px}")
        if self.min_confidence not in (0, 1, 2):
            raise ValueError(f"min_confidence: expected 0, 1 or 2, got {self.min_confidence}")


class Record3dSource(RecordedSource):
    """Frames of an .r3d file; ``seq`` is the number in the names of its files."""

    Params: ClassVar[type] = Record3dParams

    def __init__(self, params: Record3dParams) -> None:
        """Read the metadata; raise ``ValueError`` on a file that cannot be played."""
        super().__init__(params, _recording(params))


def _recording(params: Record3dParams) -> Recording:
    path = Path(params.path)
    files = Record3dFile(path, params.min_confidence)
    size = _shrunk(files.color.size, params.color_side_px)
    return Recording(
        name=path.resolve().stem,
        files=files,
        stamps_ns=files.stamps_ns,
        color_camera=resized(files.color, size),
        depth_camera=files.depth,
        T_color_depth=np.eye(4),
        color_size=files.color.size,
        depth_size=files.depth.size,
        decode_rgb=partial(decode_resized, size=size) if size != files.color.size else None,
        decode_depth_mm=partial(_depth_mm, size=files.depth.size),
    )


def _shrunk(size: Size, side_px: int) -> Size:
    scale = min(1.0, side_px / max(size))
    return round(size[0] * scale), round(size[1] * scale)


def _depth_mm(data: bytes, size: Size) -> UInt16:
    depth_mm = np.rint(np.frombuffer(data, np.float32) * np.float32(1000.0))
    held = depth_mm < np.iinfo(np.uint16).max
    return np.where(held, depth_mm, 0).astype(np.uint16).reshape(size[1], size[0])
