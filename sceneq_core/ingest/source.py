"""The seam between ingest and recordings, cameras or robots."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

from sceneq_core.arrays import Float64, UInt8, UInt16


@dataclass(frozen=True, slots=True)
class Camera:
    """Pinhole camera: ``K`` (3, 3) pixels, image ``size`` (width, height)."""

    K: Float64
    size: tuple[int, int]


@dataclass(frozen=True, slots=True)
class RawFrame:
    """What a sensor delivered at one instant, before registration and odometry.

    ``rgb`` uint8 (H, W, 3) in the colour camera; ``depth_mm`` uint16 (H, W) in the depth camera;
    ``T_world_camera`` (4, 4) pose of the DEPTH camera's frame as the source gives it, or ``None``.
    """

    seq: int
    stamp_ns: int
    rgb: UInt8
    depth_mm: UInt16
    T_world_camera: Float64 | None


@dataclass(frozen=True, slots=True)
class Skipped:
    """A source frame that could not be used: what is wrong, and where."""

    seq: int
    where: str
    reason: str


class Source(Protocol):
    """An RGB-D stream.

    ``T_color_depth`` (4, 4) maps depth-camera to colour-camera coordinates; identity together
    with equal cameras means the images are registered already.
    """

    name: str
    color_camera: Camera
    depth_camera: Camera
    T_color_depth: Float64

    def frames(self) -> Iterator[RawFrame | Skipped]:
        """Yield the frames in capture order; a bad one as ``Skipped``, never as an exception."""
