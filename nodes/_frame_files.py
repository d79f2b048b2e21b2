"""The files of every frame of a recorded folder, read and checked one at a time."""

import re
from pathlib import Path

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.transforms import rigid_defect
from sceneq_nodes import _image_file

NAME = re.compile(r"frame-(\d+)\.(color\.jpe?g|color\.png|depth\.png|pose\.txt)")

USUAL = {"color": "color.jpg", "depth": "depth.png", "pose": "pose.txt"}


class BadFileError(Exception):
    """A file of one frame that cannot be used."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"{path}: {reason}")
        self.path = path
        self.reason = reason


def lap_length(values: list[int]) -> int:
    """Return how far a lap over growing ``values`` reaches: to one more step like the last."""
    step = values[-1] - values[-2] if len(values) > 1 else 1
    return values[-1] - values[0] + step


def check_image(path: Path, data: bytes, part: str) -> tuple[int, int]:
    """Return the (width, height) of a complete image file of ``part`` (``color``, ``depth``).

    Raises:
        BadFileError: it is cut off or damaged, or the image of another part.
    """
    try:
        header = _image_file.header(data)
    except ValueError as error:
        raise BadFileError(path, str(error)) from error
    if header.is_depth != (part == "depth"):
        what = f"{header.bits} bits a channel, {header.channels} channels"
        raise BadFileError(path, f"{part} with {what}")
    return header.size


class FrameFiles:
    """Frame number and part (``color``, ``depth``, ``pose``) -> file.

    ``numbers`` are the frames with an image, sorted; ``has_poses`` when any pose file is there.
    """

    def __init__(self, folder: Path) -> None:
        """List the folder; raise ``ValueError`` when it or its frames are missing."""
        if not folder.is_dir():
            raise ValueError(f"{folder}: no such folder; say where the recording is")
        self._folder = folder
        self._paths: dict[tuple[int, str], Path] = {}
        for path in sorted(folder.iterdir()):
            if match := NAME.fullmatch(path.name):
                self._paths[int(match[1]), match[2].partition(".")[0]] = path
        self.numbers = sorted({number for number, part in self._paths if part != "pose"})
        self.has_poses = any(part == "pose" for _, part in self._paths)
        if not self.numbers:
            expected = "frame-000000.color.jpg, frame-000000.depth.png, ..."
            raise ValueError(f"{folder}: no frames; expected {expected}")

    def path(self, number: int, part: str) -> Path:
        """Return the file of one part of a frame, there or not."""
        usual = self._folder / f"frame-{number:06d}.{USUAL[part]}"
        return self._paths.get((number, part), usual)

    def image(self, number: int, part: str) -> tuple[bytes, tuple[int, int]]:
        """Return the bytes of a complete image file and its (width, height)."""
        data = self._read(number, part)
        return data, check_image(self.path(number, part), data, part)

    def pose(self, number: int) -> Float64:
        """Return the rigid T_world_camera (4, 4) of a frame."""
        path, data = self.path(number, "pose"), self._read(number, "pose")
        try:
            values = [float(value) for value in data.split()]
        except ValueError as error:
            raise BadFileError(path, f"no pose: {error}") from error
        if len(values) != 16:
            raise BadFileError(path, f"no pose: expected 16 numbers, got {len(values)}")
        T_world_camera = np.array(values).reshape(4, 4)
        if defect := rigid_defect(T_world_camera):
            raise BadFileError(path, defect)
        return T_world_camera

    def _read(self, number: int, part: str) -> bytes:
        path = self.path(number, part)
        try:
            return path.read_bytes()
        except OSError as error:
            raise BadFileError(path, error.strerror or "cannot be read") from error
