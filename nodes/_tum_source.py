"""A sequence of the TUM RGB-D benchmark, as a source.

``rgb.txt`` and ``depth.txt`` list ``timestamp path`` of every image, ``groundtruth.txt`` has
``timestamp tx ty tz qx qy qz qw`` of the camera (seconds, metres; lines with # are comments). The
depth images are registered to colour, 5000 units a metre. A colour image goes with the depth image
nearest in time, at most 20 ms away, and has the pose interpolated between the two around it, if
they are at most 0.1 s apart; one without depth is left out, one without pose is a bad frame.
Frames are numbered from 0 in the order of the colour images.

The camera is that of ``camera-intrinsics.txt`` in the folder, else the published one of
freiburg1, 2 or 3 in the folder's name. Lens distortion is not removed (freiburg3 has none).

Source: Sturm et al., IROS 2012, DOI 10.1109/IROS.2012.6385773, and the benchmark's file formats.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.source import Camera
from sceneq_nodes._camera_files import INTRINSICS, read_intrinsics
from sceneq_nodes._listed_files import ListedFiles
from sceneq_nodes._matrix_file import read_lines, read_rows
from sceneq_nodes._recorded_source import (
    RecordedParams,
    RecordedSource,
    Recording,
    depth_of_units,
    need_equal_sizes,
    usual_size,
)

COLOR_LIST, DEPTH_LIST, POSES_FILE = "rgb.txt", "depth.txt", "groundtruth.txt"
UNITS_PER_M = 5000.0
MAX_APART_S = 0.02
MAX_GAP_S = 0.1
PUBLISHED = {
    "freiburg1": (517.3, 516.5, 318.6, 255.3),
    "freiburg2": (520.9, 521.0, 325.1, 249.7),
    "freiburg3": (535.4, 539.2, 320.1, 247.6),
}
"""fx, fy, cx, cy in pixels of the colour cameras."""


@dataclass(frozen=True, slots=True)
class TumParams(RecordedParams):
    """``path`` of the sequence; else as of every recording."""


class TumSource(RecordedSource):
    """Frames of a TUM RGB-D sequence; ``seq`` counts the colour images that have depth."""

    Params: ClassVar[type] = TumParams

    def __init__(self, params: TumParams) -> None:
        """Read the lists; raise ``ValueError`` on a folder that cannot be played."""
        super().__init__(params, _recording(Path(params.path)))


def _recording(folder: Path) -> Recording:
    color, depth = _listed(folder / COLOR_LIST), _listed(folder / DEPTH_LIST)
    pairs = _pairs(np.array(list(color)), np.array(list(depth)))
    if not pairs:
        raise ValueError(f"{folder / DEPTH_LIST}: no depth within {MAX_APART_S} s of an rgb image")
    files = ListedFiles(
        color={n: color[c] for n, (c, _) in enumerate(pairs)},
        depth={n: depth[d] for n, (_, d) in enumerate(pairs)},
        poses=_poses(folder / POSES_FILE, [c for c, _ in pairs]),
        pose_file=folder / POSES_FILE,
    )
    size = usual_size(files, files.numbers, "color")
    need_equal_sizes(folder, size, usual_size(files, files.numbers, "depth"), "expected one size")
    camera = Camera(_intrinsics(folder), size)
    return Recording(
        name=folder.resolve().name,
        files=files,
        stamps_ns={n: round(c * 1e9) for n, (c, _) in enumerate(pairs)},
        color_camera=camera,
        depth_camera=camera,
        T_color_depth=np.eye(4),
        color_size=size,
        depth_size=size,
        decode_depth_mm=depth_of_units(UNITS_PER_M),
    )


def _listed(path: Path) -> dict[float, Path]:
    """Return stamp, seconds, -> file, in the order of the stamps."""
    found = {}
    for number, line in enumerate(read_lines(path), 1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        try:
            stamp_s, name = words
            found[float(stamp_s)] = path.parent / name
        except ValueError as error:
            raise ValueError(f"{path}, line {number}: expected 'timestamp file'") from error
    if not found:
        raise ValueError(f"{path}: no images")
    return dict(sorted(found.items()))


def _pairs(color_s: Float64, depth_s: Float64) -> list[tuple[float, float]]:
    """Return the stamps of every colour image and of the depth image nearest to it."""
    after = np.clip(np.searchsorted(depth_s, color_s), 1, max(len(depth_s) - 1, 1))
    after = np.minimum(after, len(depth_s) - 1)
    before = np.maximum(after - 1, 0)
    is_before = np.abs(depth_s[before] - color_s) <= np.abs(depth_s[after] - color_s)
    nearest = depth_s[np.where(is_before, before, after)]
    near = np.abs(nearest - color_s) <= MAX_APART_S
    return list(zip(color_s[near].tolist(), nearest[near].tolist(), strict=True))


def _poses(path: Path, stamps_s: list[float]) -> Mapping[int, Float64 | None]:
    """Return the pose at every stamp; a sequence without the file has none."""
    if not path.exists():
        return {}
    rows = read_rows(path, 8)
    rows = rows[np.unique(rows[:, 0], return_index=True)[1]]
    if not len(rows):
        raise ValueError(f"{path}: no poses")
    if not np.isfinite(rows).all() or (np.linalg.norm(rows[:, 4:], axis=1) < 0.5).any():
        raise ValueError(f"{path}: qx qy qz qw: expected unit quaternions and finite numbers")
    return {n: _interpolated(rows, stamp_s) for n, stamp_s in enumerate(stamps_s)}


def _interpolated(rows: Float64, stamp_s: float) -> Float64 | None:
    """Return T_world_camera (4, 4) between the poses around ``stamp_s``, ``None`` in a gap."""
    from scipy.spatial.transform import Rotation, Slerp

    after = int(np.searchsorted(rows[:, 0], stamp_s))
    if after < len(rows) and rows[after, 0] == stamp_s:
        around, share = rows[[after, after]], 0.0
    elif 0 < after < len(rows) and rows[after, 0] - rows[after - 1, 0] <= MAX_GAP_S:
        around = rows[after - 1 : after + 1]
        share = float((stamp_s - around[0, 0]) / (around[1, 0] - around[0, 0]))
    else:
        return None
    T_world_camera = np.eye(4)
    T_world_camera[:3, 3] = (1.0 - share) * around[0, 1:4] + share * around[1, 1:4]
    T_world_camera[:3, :3] = Slerp([0.0, 1.0], Rotation.from_quat(around[:, 4:]))(share).as_matrix()
    return T_world_camera


def _intrinsics(folder: Path) -> Float64:
    if (folder / INTRINSICS).exists():
        return read_intrinsics(folder)
    found = re.search("|".join(PUBLISHED), folder.resolve().name)
    if found is None:
        known = ", ".join(PUBLISHED)
        raise ValueError(f"{folder / INTRINSICS}: missing, and the name is none of {known}")
    fx, fy, cx, cy = PUBLISHED[found[0]]
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
