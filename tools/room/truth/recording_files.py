"""Writes a recording in the layout of the 7-Scenes data set, whole or not at all."""

import re
import shutil
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from sceneq_core.arrays import Array, Float64, UInt8, UInt16

JPEG_QUALITY = 92
NAMES = ("camera-intrinsics.txt", "stamps.txt", "instances.json", "queries.json",
         "ATTRIBUTION.txt", "README.md")  # fmt: skip
FRAME_FILE = re.compile(r"frame-\d{6}\.(color\.jpg|depth\.png|pose\.txt|instance\.png|mask\.png)")
SIGNATURE = "Made by `sceneq synth`"
"""First words of the README of every folder that may be written again without asking."""


@dataclass(frozen=True, slots=True, eq=False)
class FrameImages:
    """One frame: ``rgb`` (H, W, 3), ``depth_mm``, exact ``instance_id``, imperfect ``mask``."""

    rgb: UInt8
    depth_mm: UInt16
    instance_id: UInt16
    mask: UInt16


def write_frame(
    folder: Path,
    number: int,
    images: FrameImages,
    T_world_camera: Float64,
    jpeg_quality: int = JPEG_QUALITY,
) -> None:
    """Write the five files of a frame; raise ``OSError`` when one cannot be written."""
    stem = f"{folder}/frame-{number:06d}"
    quality = [cv2.IMWRITE_JPEG_QUALITY, jpeg_quality]
    _write_image(f"{stem}.color.jpg", images.rgb[..., ::-1], quality)
    _write_image(f"{stem}.depth.png", images.depth_mm, [cv2.IMWRITE_PNG_COMPRESSION, 9])
    _write_image(f"{stem}.instance.png", images.instance_id, [cv2.IMWRITE_PNG_COMPRESSION, 9])
    _write_image(f"{stem}.mask.png", images.mask, [cv2.IMWRITE_PNG_COMPRESSION, 9])
    np.savetxt(f"{stem}.pose.txt", T_world_camera, fmt="%.9g")


def write_camera(folder: Path, K: Float64, stamps_s: Float64) -> None:
    """Write the camera matrix and one stamp, seconds, a line."""
    np.savetxt(folder / "camera-intrinsics.txt", K, fmt="%.9g")
    np.savetxt(folder / "stamps.txt", stamps_s, fmt="%.6f")


class Output:
    """A folder that appears when everything is in it.

    ``with Output(path) as folder`` gives a folder beside ``path`` to write into. Left without an
    exception its content becomes ``path``; left with one, an interrupt too, it vanishes.
    """

    def __init__(self, path: Path, force: bool = False) -> None:
        """Look at ``path``.

        Raises:
            FileExistsError: there is something that is not an earlier recording of our own, and
                no ``force``; with it only the files of a recording are replaced.
            NotADirectoryError: it is a file.
        """
        self.path = path.absolute()
        self._unfinished = self.path.with_name(f".{self.path.name}.unfinished")
        if self.path.exists() and not self.path.is_dir():
            raise NotADirectoryError(f"{path}: is a file, expected a folder")
        if not force and self._is_foreign():
            raise FileExistsError(f"{path}: not empty, and no earlier output of this command")

    def __enter__(self) -> Path:
        shutil.rmtree(self._unfinished, ignore_errors=True)
        self._unfinished.mkdir(parents=True)
        return self._unfinished

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            if kind is None:
                self._publish()
        finally:
            shutil.rmtree(self._unfinished, ignore_errors=True)

    def _is_foreign(self) -> bool:
        if not self.path.is_dir() or not any(self.path.iterdir()):
            return False
        readme = self.path / "README.md"
        return not (readme.is_file() and SIGNATURE in readme.read_text(errors="replace"))

    def _publish(self) -> None:
        self.path.mkdir(parents=True, exist_ok=True)
        for path in self.path.iterdir():
            if path.name in NAMES or FRAME_FILE.fullmatch(path.name):
                path.unlink()
        for path in sorted(self._unfinished.iterdir()):
            path.replace(self.path / path.name)


def _write_image(path: str, image: Array, options: list[int]) -> None:
    if not cv2.imwrite(path, image, options):
        raise OSError(f"{path}: the image could not be written")
