"""What all recordings have in common, whatever their files look like."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any, Protocol, TypeVar

import numpy as np

from sceneq_core.arrays import Float64, UInt8, UInt16
from sceneq_core.ingest.source import Camera, RawFrame, RefusedError, Skipped
from sceneq_nodes._frame_files import BadFileError, lap_length
from sceneq_nodes._image_file import decode_depth_mm, decode_rgb

LOOKED_AT = 16
"""So many images say what size they have, so that one bad image is not the measure."""
MM_PER_M = 1000.0

Pixels = TypeVar("Pixels")
Size = tuple[int, int]


class Files(Protocol):
    """Frame number and part (``color``, ``depth``) -> encoded image, and poses.

    All methods raise ``BadFileError`` when a file cannot be used.
    """

    @property
    def numbers(self) -> list[int]:
        """All frame numbers, sorted."""

    @property
    def has_poses(self) -> bool:
        """Whether there is a pose at all."""

    def path(self, number: int, part: str) -> Path:
        """Return the file of one part of a frame, there or not."""

    def image(self, number: int, part: str) -> tuple[bytes, Size]:
        """Return a complete encoded image and its (width, height)."""

    def pose(self, number: int) -> Float64:
        """Return the rigid T_world_camera (4, 4) of the depth camera, metres."""


@dataclass(frozen=True, slots=True)
class RecordedParams:
    """``path`` of the recording; every ``step``-th of its frames; ``loop`` starts over for ever.

    Without ``use_poses`` the poses are left alone, as if there were none.
    """

    path: str
    step: int = 1
    loop: bool = False
    use_poses: bool = True

    def __post_init__(self) -> None:
        if self.step < 1:
            raise ValueError(f"step: expected 1 or more, got {self.step}")


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """The files of a recording, its cameras, and how its images are decoded.

    ``color_size`` and ``depth_size`` are those of the files: a frame of another size is bad.
    ``stamps_ns``: frame number -> capture time, growing. Without ``decode_rgb`` and
    ``decode_depth_mm`` the images are PNG or JPEG, and depth PNG in millimetres.
    """

    name: str
    files: Files
    stamps_ns: Mapping[int, int]
    color_camera: Camera
    depth_camera: Camera
    T_color_depth: Float64
    color_size: Size
    depth_size: Size
    decode_rgb: Callable[[bytes], UInt8] | None = None
    decode_depth_mm: Callable[[bytes], UInt16] | None = None


class RecordedSource:
    """Frames in the order of their numbers; ``seq`` is the number and goes on from lap to lap."""

    def __init__(self, params: RecordedParams, recording: Recording) -> None:
        self.name = recording.name
        self.color_camera = recording.color_camera
        self.depth_camera = recording.depth_camera
        self.T_color_depth = recording.T_color_depth
        self.has_poses = params.use_poses and recording.files.has_poses
        self._recording = recording
        self._files = recording.files
        self._numbers = recording.files.numbers[:: params.step]
        self._loop = params.loop

    def __len__(self) -> int:
        """Return the number of frames in one lap."""
        return len(self._numbers)

    def frames(self) -> Iterator[RawFrame | Skipped]:
        """Yield one lap, or laps without end when looping; seq and stamps keep growing.

        A lap without a single usable frame is the last: the files are gone.
        """
        stamps_ns = self._recording.stamps_ns
        # Of all frames, whatever the step: whoever knows the folder knows the length of a lap.
        lap_seq = lap_length(self._files.numbers)
        lap_ns = lap_length([stamps_ns[number] for number in self._files.numbers])
        for lap in count() if self._loop else range(1):
            usable = False
            for number in self._numbers:
                seq, stamp_ns = number + lap * lap_seq, stamps_ns[number] + lap * lap_ns
                frame = self._frame(number, seq, stamp_ns)
                usable = usable or isinstance(frame, RawFrame)
                yield frame
            if not usable:
                return

    def control(self, verb: str, arguments: Mapping[str, str]) -> dict[str, Any]:
        """Refuse: what is recorded is recorded."""
        raise RefusedError("a recording cannot be changed", "a simulation can: sceneq up --sim")

    def _frame(self, number: int, seq: int, stamp_ns: int) -> RawFrame | Skipped:
        recording = self._recording
        try:
            color = self._image(number, "color", recording.color_size)
            depth = self._image(number, "depth", recording.depth_size)
            pose = self._files.pose(number) if self.has_poses else None
        except BadFileError as error:
            return Skipped(seq, str(error.path), error.reason)
        color_path, depth_path = (str(self._files.path(number, p)) for p in ("color", "depth"))
        to_rgb = recording.decode_rgb or decode_rgb
        to_mm = recording.decode_depth_mm or decode_depth_mm
        return RawFrame(
            seq=seq,
            stamp_ns=stamp_ns,
            T_world_camera=pose,
            read_rgb=partial(_decoded, to_rgb, color, seq, color_path),
            read_depth_mm=partial(_decoded, to_mm, depth, seq, depth_path),
        )

    def _image(self, number: int, part: str, expected: Size) -> bytes:
        data, size = self._files.image(number, part)
        if size != expected:
            path = self._files.path(number, part)
            raise BadFileError(path, f"image is {_x(size)}, the camera's are {_x(expected)}")
        return data


def usual_size(files: Files, numbers: Sequence[int], part: str) -> Size:
    """Return the (width, height) that most of the first images have.

    Raises:
        ValueError: there is no usable image.
    """
    sizes: Counter[Size] = Counter()
    defects = []
    for number in numbers:
        try:
            sizes[files.image(number, part)[1]] += 1
        except BadFileError as error:
            defects.append(str(error))
        if sizes.total() == LOOKED_AT:
            break
    if not sizes:
        raise ValueError(f"no frame has a usable {part} image; the first: {defects[0]}")
    return sizes.most_common(1)[0][0]


def need_equal_sizes(folder: Path, color: Size, depth: Size, hint: str) -> None:
    """Refuse images of different sizes where one camera took both."""
    if color != depth:
        raise ValueError(f"{folder}: colour is {_x(color)}, depth is {_x(depth)}; {hint}")


def depth_of_units(units_per_m: float) -> Callable[[bytes], UInt16]:
    """Return what decodes depth images with ``units_per_m`` to millimetres."""
    if units_per_m == MM_PER_M:
        return decode_depth_mm
    return partial(_decode_units, mm_per_unit=MM_PER_M / units_per_m)


def _decode_units(data: bytes, mm_per_unit: float) -> UInt16:
    depth_mm = np.rint(decode_depth_mm(data) * mm_per_unit)
    # Beyond what millimetres can say in 16 bits is out of sight of every sensor.
    return np.where(depth_mm < np.iinfo(np.uint16).max, depth_mm, 0).astype(np.uint16)


def _decoded(
    decode: Callable[[bytes], Pixels], data: bytes, seq: int, path: str
) -> Pixels | Skipped:
    try:
        return decode(data)
    except ValueError as error:
        return Skipped(seq, path, str(error))


def _x(size: Size) -> str:
    return f"{size[0]}x{size[1]}"
