"""A recording in the layout of Open3D's reconstruction system and of Redwood, as a source.

``color/`` (or ``rgb/``, ``image/``) and ``depth/`` (PNG, uint16 millimetres, registered to colour)
with images that go together by their order or, where names end in ``-MICROSECONDS`` (Redwood's
object scans), by time, at most 20 ms apart. ``trajectory.log`` (also in ``scene/``) has five lines
a frame: ``i i n`` with the number of the frame, then its 4x4 T_world_camera. ``camera_intrinsic
.json`` (or ``intrinsic.json``) is what ``open3d.io.write_pinhole_camera_intrinsic`` writes, the
matrix in columns; without it the camera is Redwood's own, a PrimeSense of 640 x 480.

Source: Choi et al., CVPR 2015, DOI 10.1109/CVPR.2015.7299195, and Open3D's file formats.
"""

import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.source import Camera
from sceneq_nodes._camera_files import nominal_stamps_ns
from sceneq_nodes._listed_files import ListedFiles
from sceneq_nodes._matrix_file import read_lines
from sceneq_nodes._recorded_source import (
    RecordedParams,
    RecordedSource,
    Recording,
    depth_of_units,
    need_equal_sizes,
    usual_size,
)

COLORS, DEPTH = ("color", "rgb", "image"), "depth"
CAMERAS = ("camera_intrinsic.json", "intrinsic.json")
POSES = ("trajectory.log", "scene/trajectory.log")
IMAGE = re.compile(r"\d*[-_]?(\d+)\.(?:jpe?g|png)")
STAMPED = re.compile(r"\d+-(\d+)\.(?:jpe?g|png)")
MAX_APART_US = 20_000
PRIMESENSE = (640, 480), (525.0, 525.0, 319.5, 239.5)
"""Size, and fx, fy, cx, cy in pixels, that Redwood's recordings were made with."""


@dataclass(frozen=True, slots=True)
class RedwoodParams(RecordedParams):
    """``path`` of the recording; ``units_per_m`` of its depth images."""

    units_per_m: float = 1000.0

    def __post_init__(self) -> None:
        RecordedParams.__post_init__(self)
        if not self.units_per_m > 0:
            raise ValueError(f"units_per_m: expected above 0, got {self.units_per_m}")


class RedwoodSource(RecordedSource):
    """Frames in the order of the colour images; ``seq`` counts them from 0."""

    Params: ClassVar[type] = RedwoodParams

    def __init__(self, params: RedwoodParams) -> None:
        """Read camera and poses; raise ``ValueError`` on a folder that cannot be played."""
        super().__init__(params, _recording(Path(params.path), params.units_per_m))


def color_folder(folder: Path) -> Path | None:
    """Return where the colour images lie, ``None`` when there is no such folder."""
    return next((folder / name for name in COLORS if (folder / name).is_dir()), None)


def _recording(folder: Path, units_per_m: float) -> Recording:
    files, stamps_ns = _files(folder)
    size = usual_size(files, files.numbers, "color")
    need_equal_sizes(folder, size, usual_size(files, files.numbers, "depth"), "register the depth")
    camera = _camera(folder, size)
    return Recording(
        name=folder.resolve().name,
        files=files,
        stamps_ns=stamps_ns,
        color_camera=camera,
        depth_camera=camera,
        T_color_depth=np.eye(4),
        color_size=size,
        depth_size=size,
        decode_depth_mm=depth_of_units(units_per_m),
    )


def _files(folder: Path) -> tuple[ListedFiles, dict[int, int]]:
    where = color_folder(folder)
    color = [] if where is None else _images(where)
    depth = _images(folder / DEPTH) if (folder / DEPTH).is_dir() else []
    if not (color and depth):
        expected = "color/ (or rgb/, image/) and depth/ with 000000.jpg, 000000.png, ..."
        raise ValueError(f"{folder}: no frames; expected {expected}")
    pairs, stamps_ns = _pairs(folder, color, depth)
    pose_file = next((folder / name for name in POSES if (folder / name).is_file()), None)
    files = ListedFiles(
        color={n: c for n, (c, _) in enumerate(pairs)},
        depth={n: d for n, (_, d) in enumerate(pairs)},
        poses={} if pose_file is None else dict(_poses(pose_file)),
        pose_file=pose_file or folder / POSES[0],
    )
    return files, stamps_ns


def _images(folder: Path) -> list[Path]:
    found = [(match, path) for path in folder.iterdir() if (match := IMAGE.fullmatch(path.name))]
    return [path for _, path in sorted(found, key=lambda one: (len(one[1].stem), one[1].stem))]


def _pairs(
    folder: Path, color: list[Path], depth: list[Path]
) -> tuple[list[tuple[Path, Path]], dict[int, int]]:
    """Return the images that go together, and when each pair was taken."""
    stamps_us = [_stamps_us(color), _stamps_us(depth)]
    if not all(stamps_us):
        if len(color) != len(depth):
            raise ValueError(f"{folder}: {len(color)} colour images, {len(depth)} depth images")
        return list(zip(color, depth, strict=True)), nominal_stamps_ns(list(range(len(color))))
    color_us, depth_us = (np.array(values, np.int64) for values in stamps_us)
    nearest = np.abs(depth_us[None] - color_us[:, None]).argmin(axis=1)
    near = np.flatnonzero(np.abs(depth_us[nearest] - color_us) <= MAX_APART_US)
    if not len(near):
        raise ValueError(f"{folder}: no depth within {MAX_APART_US} us of a colour image")
    pairs = [(color[i], depth[nearest[i]]) for i in near.tolist()]
    return pairs, {n: 1000 * int(color_us[i]) for n, i in enumerate(near.tolist())}


def _stamps_us(images: list[Path]) -> list[int]:
    """Return the stamps in the names, none when the names have none or these do not grow."""
    stamps = [int(match[1]) for path in images if (match := STAMPED.fullmatch(path.name))]
    return stamps if len(stamps) == len(images) and (np.diff(stamps) > 0).all() else []


def _poses(path: Path) -> dict[int, Float64 | None]:
    """Return frame number -> pose; where the numbers say nothing the order does."""
    words = [line.split() for line in read_lines(path) if line.strip()]
    try:
        heads = [int(words[i][0]) for i in range(0, len(words), 5)]
        rows = [[float(word) for word in row] for i, row in enumerate(words) if i % 5]
        poses = np.array(rows, np.float64).reshape(-1, 4, 4)
    except (ValueError, IndexError) as error:
        expected = "'i i n' and the four rows of a 4x4 matrix, frame by frame"
        raise ValueError(f"{path}: {error}; expected {expected}") from error
    if len(heads) != len(poses):
        raise ValueError(f"{path}: the last pose is cut off")
    numbers = heads if (np.diff(heads) > 0).all() else list(range(len(heads)))
    return dict(zip(numbers, poses, strict=True))


def _camera(folder: Path, size: tuple[int, int]) -> Camera:
    path = next((folder / name for name in CAMERAS if (folder / name).is_file()), None)
    if path is not None:
        return _read_camera(path, size)
    published, (fx, fy, cx, cy) = PRIMESENSE
    if size != published:
        raise ValueError(
            f"{folder / CAMERAS[0]}: missing, and {size[0]}x{size[1]} is not Redwood's 640x480"
        )
    return Camera(np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]), size)


def _read_camera(path: Path, size: tuple[int, int]) -> Camera:
    try:
        document = json.loads(path.read_text())
        K = np.array(document["intrinsic_matrix"], np.float64).reshape(3, 3).T
        given = int(document["width"]), int(document["height"])
    except (OSError, ValueError, TypeError, KeyError) as error:
        expected = '{"width", "height", "intrinsic_matrix": 9 numbers, column by column}'
        raise ValueError(f"{path}: {error}; expected {expected}") from error
    if given != size:
        raise ValueError(f"{path}: says {given[0]}x{given[1]}, the images are {size[0]}x{size[1]}")
    if not (np.isfinite(K).all() and K[0, 0] > 0 and K[1, 1] > 0 and K[2, 2] == 1):
        raise ValueError(f"{path}: intrinsic_matrix: no camera matrix: {K.tolist()}")
    return Camera(K, size)
