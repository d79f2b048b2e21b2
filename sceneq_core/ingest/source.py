"""The seam between ingest and recordings, cameras or robots."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

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
    """

    seq: int
    stamp_ns: int
    T_world_camera: Float64 | None
    read_rgb: Callable[[], UInt8 | Skipped]
    read_depth_mm: Callable[[], UInt16 | Skipped]


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
