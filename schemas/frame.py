"""What ingest writes: keyframes and the pose of every frame."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from sceneq_schemas.arrays import Array, ArraySpec


@dataclass(frozen=True, slots=True)
class ImageData:
    """An image as bytes.

    ``codec`` is ``raw`` (little-endian pixels in C order), ``jpeg`` (colour), ``zstd`` (raw,
    compressed) or ``delta`` (depth: with ``d`` each pixel less its left neighbour modulo 2^16, the
    low bytes of ``2d ^ -(d >> 15)`` of all pixels, then the high ones, compressed). ``dtype``
    is ``|u1`` or ``<u2``; ``shape`` is (H, W) or (H, W, 3).
    """

    codec: str
    dtype: str
    shape: tuple[int, ...]
    data: bytes


@dataclass(frozen=True, slots=True)
class Frame:
    """A keyframe: colour and registered depth of one instant, with its camera and pose.

    ``rgb`` is RGB uint8 (H, W, 3); ``depth_mm`` is uint16 (H, W) millimetres along the optical
    axis in the colour camera, 0 = no measurement; ``K`` pinhole intrinsics in pixels;
    ``T_world_camera`` maps camera to world coordinates in metres (OpenCV axes). ``after`` is the
    seq of the keyframe that has to be taken in before, for a lost one comes again and is not to be
    overtaken; its own seq if it is the first; -1 where frames may be lost for good.
    """

    VERSION: ClassVar[int] = 1
    SCHEMA: ClassVar[str] = "sceneq.frame.v1"
    seq: int
    stamp_ns: int
    rgb: ImageData
    depth_mm: ImageData
    K: Annotated[Array, ArraySpec("<f8", (3, 3))]
    T_world_camera: Annotated[Array, ArraySpec("<f8", (4, 4))]
    after: int = -1


@dataclass(frozen=True, slots=True)
class Pose:
    """Where the camera was at one source frame; ``source`` is ``given`` or the odometry's kind."""

    VERSION: ClassVar[int] = 1
    SCHEMA: ClassVar[str] = "sceneq.pose.v1"
    seq: int
    stamp_ns: int
    T_world_camera: Annotated[Array, ArraySpec("<f8", (4, 4))]
    source: str
    keyframe: bool
