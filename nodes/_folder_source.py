"""A recorded folder in the layout of the 7-Scenes data set, as a source.

``frame-NNNNNN.color.jpg|png``, ``.depth.png`` (uint16 millimetres; 0 and 65535 are no
measurement), ``.pose.txt`` (4x4 T_world_camera of the depth camera, metres), one
``camera-intrinsics.txt`` of the depth camera, and where there are two cameras
``camera-color.json``. Numbers may skip. A folder without any pose file is a stream without poses.

The sequences of 7-Scenes themselves come without a camera: PNG images of 640 x 480 in a folder
without ``camera-intrinsics.txt`` are the Kinect's, with the intrinsics its authors used.

Source: Shotton et al., CVPR 2013, DOI 10.1109/CVPR.2013.377.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.source import Camera
from sceneq_nodes._camera_files import (
    INTRINSICS,
    read_color_camera,
    read_intrinsics,
    read_stamps_ns,
)
from sceneq_nodes._frame_files import FrameFiles
from sceneq_nodes._recorded_source import (
    RecordedParams,
    RecordedSource,
    Recording,
    Size,
    need_equal_sizes,
    usual_size,
)

KINECT_SIZE = (640, 480)
KINECT_DEPTH = np.array([[585.0, 0.0, 320.0], [0.0, 585.0, 240.0], [0.0, 0.0, 1.0]])
KINECT_COLOR = np.array([[525.0, 0.0, 320.0], [0.0, 525.0, 240.0], [0.0, 0.0, 1.0]])
"""The Kinect's nominal cameras; how far they are apart, 2.5 cm, nobody calibrated."""
TWO_CAMERAS = "say in camera-color.json how the two cameras differ (K, T_color_depth)"


@dataclass(frozen=True, slots=True)
class FolderParams(RecordedParams):
    """``path`` of the folder; every ``step``-th of its frames; ``loop`` starts over for ever.

    Without ``use_poses`` the pose files are left alone, as if there were none.
    """


class FolderSource(RecordedSource):
    """Frames of a folder; ``seq`` is the number in the names of its files."""

    Params: ClassVar[type] = FolderParams

    def __init__(self, params: FolderParams) -> None:
        """Read the cameras; raise ``ValueError`` on a folder that cannot be played."""
        super().__init__(params, _recording(Path(params.path), params.step))


def _recording(folder: Path, step: int) -> Recording:
    files = FrameFiles(folder)
    played = files.numbers[::step]
    stamps_ns = read_stamps_ns(folder, files.numbers)
    depth_size, color_size = (usual_size(files, played, part) for part in ("depth", "color"))
    if _is_kinect(folder, files, color_size, depth_size):
        depth_camera, color_camera = (Camera(K, color_size) for K in (KINECT_DEPTH, KINECT_COLOR))
        T_color_depth = np.eye(4)
    else:
        depth_camera = Camera(read_intrinsics(folder), depth_size)
        color_camera, T_color_depth = _color_camera(folder, depth_camera, color_size)
    return Recording(
        name=folder.resolve().name,
        files=files,
        stamps_ns=stamps_ns,
        color_camera=color_camera,
        depth_camera=depth_camera,
        T_color_depth=T_color_depth,
        color_size=color_size,
        depth_size=depth_size,
    )


def _is_kinect(folder: Path, files: FrameFiles, color_size: Size, depth_size: Size) -> bool:
    """Tell a sequence of 7-Scenes as it was published, by all that it has and lacks."""
    is_png = files.path(files.numbers[0], "color").suffix == ".png"
    has_size = color_size == depth_size == KINECT_SIZE
    return is_png and has_size and not (folder / INTRINSICS).exists()


def _color_camera(folder: Path, depth_camera: Camera, size: Size) -> tuple[Camera, Float64]:
    camera = read_color_camera(folder)
    if camera is not None:
        K, T_color_depth = camera
        return Camera(K, size), T_color_depth
    need_equal_sizes(folder, size, depth_camera.size, TWO_CAMERAS)
    return depth_camera, np.eye(4)
