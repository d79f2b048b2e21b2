"""The seam between ingest and recordings, cameras or robots."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from sceneq_core.arrays import Float64, UInt8, UInt16


@dataclass(frozen=True, slots=True)
class Camera:
    """Pinhole camera: ``K`` (3, 3) pixels, image ``size`` (width, height)."""

    K: Float64
    size: tuple[int, int]


@dataclass(frozen=True, slots=True)
class Skipped:
    """A source frame that could not be used: what is wrong, and where."""

    seq: int
    where: str
    reason: str


@dataclass(frozen=True, slots=True)
class RawFrame:
    """What a sensor delivered at one instant, before registration and odometry.

    Images are decoded on demand, for most frames of a posed stream never become keyframes.

    Attributes:
        seq: number of the frame, growing.
        stamp_ns: capture time, nanoseconds.
        T_world_camera: (4, 4) pose of the DEPTH camera as the source gives it, metres, or ``None``
            when the source has no poses.
        read_rgb: returns uint8 (H, W, 3) RGB in the colour camera.
        read_depth_mm: returns uint16 (H, W) millimetres in the depth camera, 0 = no measurement.
        corrected: poses of earlier frames, by seq, that the source knows better from here on.
    """

    seq: int
    stamp_ns: int
    T_world_camera: Float64 | None
    read_rgb: Callable[[], UInt8 | Skipped]
    read_depth_mm: Callable[[], UInt16 | Skipped]
    corrected: Mapping[int, Float64] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Waiting:
    """What a live source yields when it has no frame yet; it is asked again a little later."""


class RefusedError(ValueError):
    """What a source will not do, and ``hint``: what it would."""

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.hint = hint


class Source(Protocol):
    """An RGB-D stream.

    ``T_color_depth`` (4, 4) maps depth-camera to colour-camera coordinates; identity together
    with equal cameras means the images are registered already. ``has_poses``: every frame comes
    with a pose, or else none does.
    """

    name: str
    color_camera: Camera
    depth_camera: Camera
    T_color_depth: Float64
    has_poses: bool

    def frames(self) -> Iterator[RawFrame | Skipped]:
        """Yield the frames in capture order; a bad one as ``Skipped``, never as an exception."""

    def control(self, verb: str, arguments: Mapping[str, str]) -> dict[str, Any]:
        """Change what is in front of the camera, as ``move`` with ``{"thing": "mug", ...}`` does.

        May be called on any thread; takes effect between two frames.

        Returns:
            What was done, in values that JSON knows.

        Raises:
            RefusedError: this source cannot be changed at all, or not like that.
        """
