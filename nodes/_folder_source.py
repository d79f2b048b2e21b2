"""A recorded folder in the layout of the 7-Scenes data set, as a source.

``frame-NNNNNN.color.jpg|png``, ``.depth.png`` (uint16 millimetres; 0 and 65535 are no
measurement), ``.pose.txt`` (4x4 T_world_camera of the depth camera, metres), one
``camera-intrinsics.txt`` of the depth camera, and where there are two cameras
``camera-color.json``. Numbers may skip. A folder without any pose file is a stream without poses.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from typing import ClassVar, TypeVar

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.source import Camera, RawFrame, Skipped
from sceneq_nodes._camera_files import read_color_camera, read_intrinsics, read_stamps_ns
from sceneq_nodes._frame_files import BadFileError, FrameFiles, lap_length
from sceneq_nodes._image_file import decode_depth_mm, decode_rgb

LOOKED_AT = 16
"""So many images say what size they have, so that one bad image is not the measure."""

Pixels = TypeVar("Pixels")


@dataclass(frozen=True, slots=True)
class FolderParams:
    """``path`` of the folder; every ``step``-th of its frames; ``loop`` starts over for ever.

    Without ``use_poses`` the pose files are left alone, as if there were none.
    """

    path: str
    step: int = 1
    loop: bool = False
    use_poses: bool = True

    def __post_init__(self) -> None:
        if self.step < 1:
            raise ValueError(f"step: expected 1 or more, got {self.step}")


class FolderSource:
    """Frames in the order of their numbers; ``seq`` is the number and goes on from lap to lap."""

    Params: ClassVar[type] = FolderParams

    def __init__(self, params: FolderParams) -> None:
        """Read the cameras; raise ``ValueError`` on a folder that cannot be played."""
        folder = Path(params.path)
        self.name = folder.resolve().name
        self._files = FrameFiles(folder)
        self._numbers = self._files.numbers[:: params.step]
        self._stamps_ns = read_stamps_ns(folder, self._files.numbers)
        self._loop = params.loop
        self.has_poses = params.use_poses and self._files.has_poses
        self.depth_camera = Camera(read_intrinsics(folder), self._usual_size("depth"))
        self.color_camera, self.T_color_depth = self._color_camera(folder)

    def __len__(self) -> int:
        """Return the number of frames in one lap."""
        return len(self._numbers)

    def frames(self) -> Iterator[RawFrame | Skipped]:
        """Yield one lap, or laps without end when looping; seq and stamps keep growing.

        A lap without a single usable frame is the last: the files are gone.
        """
        stamps_ns = [self._stamps_ns[number] for number in self._numbers]
        # Of all frames, whatever the step: whoever knows the folder knows the length of a lap.
        lap_seq = lap_length(self._files.numbers)
        lap_ns = lap_length([self._stamps_ns[number] for number in self._files.numbers])
        for lap in count() if self._loop else range(1):
            usable = False
            for number, stamp_ns in zip(self._numbers, stamps_ns, strict=True):
                frame = self._frame(number, number + lap * lap_seq, stamp_ns + lap * lap_ns)
                usable = usable or isinstance(frame, RawFrame)
                yield frame
            if not usable:
                return

    def _frame(self, number: int, seq: int, stamp_ns: int) -> RawFrame | Skipped:
        try:
            color = self._image(number, "color", self.color_camera.size)
            depth = self._image(number, "depth", self.depth_camera.size)
            pose = self._files.pose(number) if self.has_poses else None
        except BadFileError as error:
            return Skipped(seq, str(error.path), error.reason)
        color_path, depth_path = (str(self._files.path(number, p)) for p in ("color", "depth"))
        return RawFrame(
            seq=seq,
            stamp_ns=stamp_ns,
            T_world_camera=pose,
            read_rgb=partial(_decoded, decode_rgb, color, seq, color_path),
            read_depth_mm=partial(_decoded, decode_depth_mm, depth, seq, depth_path),
        )

    def _image(self, number: int, part: str, expected: tuple[int, int]) -> bytes:
        data, size = self._files.image(number, part)
        if size != expected:
            path = self._files.path(number, part)
            raise BadFileError(path, f"image is {_x(size)}, the camera's are {_x(expected)}")
        return data

    def _color_camera(self, folder: Path) -> tuple[Camera, Float64]:
        size = self._usual_size("color")
        camera = read_color_camera(folder)
        if camera is not None:
            K, T_color_depth = camera
            return Camera(K, size), T_color_depth
        if size != self.depth_camera.size:
            raise ValueError(
                f"{folder}: colour is {_x(size)}, depth is {_x(self.depth_camera.size)}; "
                "say in camera-color.json how the two cameras differ (K, T_color_depth)"
            )
        return self.depth_camera, np.eye(4)

    def _usual_size(self, part: str) -> tuple[int, int]:
        sizes: Counter[tuple[int, int]] = Counter()
        defects = []
        for number in self._numbers:
            try:
                sizes[self._files.image(number, part)[1]] += 1
            except BadFileError as error:
                defects.append(str(error))
            if sizes.total() == LOOKED_AT:
                break
        if not sizes:
            raise ValueError(f"no frame has a usable {part} image; the first: {defects[0]}")
        return sizes.most_common(1)[0][0]


def _decoded(
    decode: Callable[[bytes], Pixels], data: bytes, seq: int, path: str
) -> Pixels | Skipped:
    try:
        return decode(data)
    except ValueError as error:
        return Skipped(seq, path, str(error))


def _x(size: tuple[int, int]) -> str:
    return f"{size[0]}x{size[1]}"
