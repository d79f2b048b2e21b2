"""A scene of Replica as NICE-SLAM rendered it, as a source.

``results/frame000000.jpg`` and ``results/depth000000.png``, ``traj.txt`` with one row-major 4x4
T_world_camera a line and frame (OpenCV axes), and ``cam_params.json`` in the scene or the folder
above: ``{"camera": {"w", "h", "fx", "fy", "cx", "cy", "scale"}}``, ``scale`` being depth units a
metre. There are no stamps: the frames count as taken at 30 Hz.
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
from sceneq_nodes._matrix_file import read_rows
from sceneq_nodes._recorded_source import (
    RecordedParams,
    RecordedSource,
    Recording,
    depth_of_units,
)

CAMERA_FILE, POSES_FILE, IMAGES = "cam_params.json", "traj.txt", "results"
COLOR_NAME = re.compile(r"frame(\d+)\.(?:jpg|png)")


@dataclass(frozen=True, slots=True)
class ReplicaParams(RecordedParams):
    """``path`` of the scene, such as Replica/office0; else as of every recording."""


class ReplicaSource(RecordedSource):
    """Frames of a rendered Replica scene; ``seq`` is the number in the names of the images."""

    Params: ClassVar[type] = ReplicaParams

    def __init__(self, params: ReplicaParams) -> None:
        """Read camera and poses; raise ``ValueError`` on a folder that cannot be played."""
        super().__init__(params, _recording(Path(params.path)))


def _recording(folder: Path) -> Recording:
    files = _files(folder)
    camera, units_per_m = _camera(folder)
    return Recording(
        name=folder.resolve().name,
        files=files,
        stamps_ns=nominal_stamps_ns(files.numbers),
        color_camera=camera,
        depth_camera=camera,
        T_color_depth=np.eye(4),
        color_size=camera.size,
        depth_size=camera.size,
        decode_depth_mm=depth_of_units(units_per_m),
    )


def _files(folder: Path) -> ListedFiles:
    images = folder / IMAGES
    if not images.is_dir():
        raise ValueError(
            f"{images}: no such folder; expected frame000000.jpg, depth000000.png, ..."
        )
    found = ((COLOR_NAME.fullmatch(path.name), path) for path in sorted(images.iterdir()))
    color = {int(match[1]): path for match, path in found if match}
    if not color:
        raise ValueError(f"{images}: no frames; expected frame000000.jpg, depth000000.png, ...")
    depth = {n: images / f"depth{_digits(path)}.png" for n, path in color.items()}
    rows = read_rows(folder / POSES_FILE, 16).reshape(-1, 4, 4)
    poses: dict[int, Float64 | None] = dict(enumerate(rows))
    return ListedFiles(color, depth, poses, folder / POSES_FILE)


def _digits(color: Path) -> str:
    return color.stem.removeprefix("frame")


def _camera(folder: Path) -> tuple[Camera, float]:
    paths = (folder / CAMERA_FILE, folder.absolute().parent / CAMERA_FILE)
    path = next((path for path in paths if path.is_file()), paths[0])
    try:
        values = json.loads(path.read_text())["camera"]
        w, h, fx, fy, cx, cy, scale = (
            float(values[name]) for name in ("w", "h", "fx", "fy", "cx", "cy", "scale")
        )
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}, nor in the folder above") from error
    except KeyError as error:
        raise ValueError(f"{path}: no field {error.args[0]!r}") from error
    except (ValueError, TypeError) as error:
        raise ValueError(f"{path}: camera: {error}") from error
    if min(w, h, fx, fy, scale) <= 0:
        raise ValueError(f"{path}: w, h, fx, fy and scale: expected above 0, got {values}")
    K = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
    return Camera(K, (round(w), round(h))), scale
