"""A scan of ScanNet, as a source: its ``.sens`` file, or the frames extracted from it.

Extracted frames are what ScanNet's own reader writes: ``color/0.jpg``, ``depth/0.png`` (uint16
millimetres), ``pose/0.txt`` (4x4 T_world_camera) and ``intrinsic/intrinsic_color.txt``,
``intrinsic_depth.txt``, ``extrinsic_color.txt``, ``extrinsic_depth.txt``; the extrinsics map each
camera to what has the pose, and may be missing when both are the identity. World is that of
``_vh_clean_2.ply``. A pose that the reconstruction lost (-inf) makes a bad frame.

Colour has four times the pixels of depth: by default it is shrunk to the size of the depth, so
that both see a surface equally well and a frame costs a quarter.
"""

from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import ClassVar

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.source import Camera
from sceneq_core.ingest.transforms import inverse, rigid_defect
from sceneq_nodes._camera_files import nominal_stamps_ns
from sceneq_nodes._listed_files import ListedFiles
from sceneq_nodes._matrix_file import read_matrix
from sceneq_nodes._recorded_source import (
    Files,
    RecordedParams,
    RecordedSource,
    Recording,
    usual_size,
)
from sceneq_nodes._resized import decode_resized, resized
from sceneq_nodes._sens_file import SensFile

CONTAINER = "*.sens"
COLOR, DEPTH, POSE, INTRINSIC = "color", "depth", "pose", "intrinsic"


@dataclass(frozen=True, slots=True)
class ScannetParams(RecordedParams):
    """``path`` of the scan's folder or of its .sens file; ``shrink_color`` to the depth's size."""

    shrink_color: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class _Cameras:
    """Both cameras as their files have them, and T_color_depth (4, 4)."""

    color: Camera
    depth: Camera
    T_color_depth: Float64


class ScannetSource(RecordedSource):
    """Frames of a ScanNet scan; ``seq`` is ScanNet's own number of the frame."""

    Params: ClassVar[type] = ScannetParams

    def __init__(self, params: ScannetParams) -> None:
        """Read cameras and poses; raise ``ValueError`` on a scan that cannot be played."""
        path = Path(params.path)
        container = (
            path if path.suffix == ".sens" else next(iter(sorted(path.glob(CONTAINER))), None)
        )
        recording = (
            _of_container(path, container, params) if container else _of_folder(path, params)
        )
        super().__init__(params, recording)


def _of_container(path: Path, container: Path, params: ScannetParams) -> Recording:
    sens = SensFile(container)
    head = sens.head
    T_color_depth = _T_color_depth(container, head.T_rig_color, head.T_rig_depth)
    cameras = _Cameras(head.color, head.depth, T_color_depth)
    stamps_ns = {n: 1000 * stamp_us for n, stamp_us in enumerate(sens.stamps_us)}
    if any(later <= earlier for earlier, later in pairwise(stamps_ns.values())):
        stamps_ns = nominal_stamps_ns(sens.numbers)  # some scans have none
    recording = _recording(path.resolve().stem, sens, stamps_ns, cameras, params.shrink_color)
    return replace(recording, decode_depth_mm=sens.decode_depth_mm)


def _of_folder(folder: Path, params: ScannetParams) -> Recording:
    files = _files(folder)
    intrinsic, played = folder / INTRINSIC, files.numbers[:: params.step]
    color, depth = (
        Camera(_intrinsics(intrinsic, part), usual_size(files, played, part))
        for part in (COLOR, DEPTH)
    )
    extrinsics = (_extrinsic(intrinsic / f"extrinsic_{part}.txt") for part in (COLOR, DEPTH))
    cameras = _Cameras(color, depth, _T_color_depth(intrinsic, *extrinsics))
    stamps_ns = nominal_stamps_ns(files.numbers)
    return _recording(folder.resolve().name, files, stamps_ns, cameras, params.shrink_color)


def _recording(
    name: str, files: Files, stamps_ns: dict[int, int], cameras: _Cameras, shrink: bool
) -> Recording:
    color, depth = cameras.color, cameras.depth
    shrink = shrink and depth.size < color.size
    return Recording(
        name=name,
        files=files,
        stamps_ns=stamps_ns,
        color_camera=resized(color, depth.size) if shrink else color,
        depth_camera=depth,
        T_color_depth=cameras.T_color_depth,
        color_size=color.size,
        depth_size=depth.size,
        decode_rgb=partial(decode_resized, size=depth.size) if shrink else None,
    )


def _files(folder: Path) -> ListedFiles:
    for part in (COLOR, DEPTH, POSE):
        if not (folder / part).is_dir():
            raise ValueError(
                f"{folder / part}: no such folder; expected a .sens file, or color/0.jpg, "
                "depth/0.png, pose/0.txt and intrinsic/"
            )
    color = _numbered(folder / COLOR, (".jpg", ".png"))
    if not color:
        raise ValueError(f"{folder / COLOR}: no frames; expected 0.jpg, ...")
    return ListedFiles(
        color=color,
        depth={n: folder / DEPTH / f"{path.stem}.png" for n, path in color.items()},
        poses={n: _pose(folder / POSE / f"{path.stem}.txt") for n, path in color.items()},
        pose_file=folder / POSE,
    )


def _numbered(folder: Path, suffixes: tuple[str, ...]) -> dict[int, Path]:
    paths = [p for p in folder.iterdir() if p.stem.isdecimal() and p.suffix in suffixes]
    return {int(path.stem): path for path in sorted(paths, key=lambda path: int(path.stem))}


def _pose(path: Path) -> Float64 | None:
    """Return the pose as it is written; a frame without the file has none."""
    return read_matrix(path) if path.exists() else None


def _extrinsic(path: Path) -> Float64:
    return read_matrix(path) if path.exists() else np.eye(4)


def _T_color_depth(where: Path, T_rig_color: Float64, T_rig_depth: Float64) -> Float64:  # noqa: N802
    for name, T_rig_camera in (("color", T_rig_color), ("depth", T_rig_depth)):
        if defect := rigid_defect(T_rig_camera):
            raise ValueError(f"{where}: extrinsic_{name}: {defect}")
    T_color_depth: Float64 = inverse(T_rig_color) @ T_rig_depth
    return T_color_depth


def _intrinsics(folder: Path, part: str) -> Float64:
    path = folder / f"intrinsic_{part}.txt"
    K: Float64 = read_matrix(path)[:3, :3].copy()
    if not (np.isfinite(K).all() and K[0, 0] > 0 and K[1, 1] > 0):
        raise ValueError(f"{path}: no camera matrix: {K.tolist()}")
    return K
