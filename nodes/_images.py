"""Images and frames as they travel: raw, JPEG or zstd bytes, checked before allocation."""

import math

import numpy as np
import zstandard

from sceneq_core.arrays import Array, Float32, Float64
from sceneq_core.frame import Frame, depth_from_mm, depth_to_mm
from sceneq_core.ingest.transforms import rigid_defect
from sceneq_core.views.jpeg import jpeg_from_rgb, jpeg_size, rgb_from_jpeg
from sceneq_nodes._depth_codec import compressed_depth, depth_from_planes
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.frame import Frame as FrameMessage
from sceneq_schemas.frame import ImageData

ZSTD_LEVEL = 1
MAX_SIDE_PX = 16_384
MAX_IMAGE_BYTES = 64 * 1024 * 1024
"""22 million pixels of colour: few bytes may claim no more memory than that."""

_DTYPES = ("|u1", "<u2")


def image_data(array: Array, codec: str) -> ImageData:
    """Return uint8 or uint16 pixels (H, W) or (H, W, 3) as bytes in ``codec``.

    Raises:
        ValueError: unknown codec, or an array that this codec cannot carry.
    """
    dtype = array.dtype.newbyteorder("<").str
    if dtype not in _DTYPES or not _is_image_shape(array.shape):
        raise ValueError(f"no image: dtype {array.dtype}, shape {array.shape}")
    if codec == "raw":
        data = _little_endian(array)
    elif codec == "zstd":
        data = zstandard.ZstdCompressor(level=ZSTD_LEVEL).compress(_little_endian(array))
    elif codec == "delta" and array.ndim == 2 and dtype == "<u2":
        data = compressed_depth(array)
    elif codec == "jpeg":
        data = jpeg_from_rgb(array)
    else:
        raise ValueError(f"unknown image codec {codec!r}; known: raw, jpeg, zstd, delta (depth)")
    return ImageData(codec, dtype, array.shape, data)


def array_from_image(image: ImageData) -> Array:
    """Return the pixels of ``image`` (may be read-only); colour is RGB.

    Raises:
        DecodeError: unknown codec or dtype, a shape out of limits, or bytes that do not hold it.
    """
    size_bytes = _checked_size(image)
    if image.codec == "raw":
        return _from_raw(image, image.data, size_bytes)
    if image.codec == "zstd":
        return _from_raw(image, _decompress(image.data, size_bytes), size_bytes)
    if image.codec == "delta" and image.dtype == "<u2" and len(image.shape) == 2:
        return depth_from_planes(_decompress(image.data, size_bytes), image.shape)
    if image.codec == "jpeg":
        return _from_jpeg(image)
    raise DecodeError(f"image: unknown codec {image.codec!r:.40}")


def frame_message(frame: Frame, rgb_codec: str, depth_codec: str) -> FrameMessage:
    """Return the message for ``frame`` with its images in the given codecs."""
    return FrameMessage(
        seq=frame.seq,
        stamp_ns=frame.stamp_ns,
        rgb=image_data(frame.rgb, rgb_codec),
        depth_mm=image_data(depth_to_mm(frame.depth_m), depth_codec),
        K=frame.K,
        T_world_camera=frame.T_world_camera,
    )


def frame_from_message(message: FrameMessage) -> Frame:
    """Return the frame in ``message``.

    Raises:
        DecodeError: an image that does not decode, colour and depth of different size, intrinsics
            that are no pinhole camera or a pose that is not finite and rigid.
    """
    rgb = _pixels(message.rgb, "rgb", "|u1", channels=3)
    depth_m: Float32 = depth_from_mm(_pixels(message.depth_mm, "depth_mm", "<u2", channels=1))
    if rgb.shape[:2] != depth_m.shape:
        raise DecodeError(f"Frame: rgb is {rgb.shape[:2]}, depth_mm is {depth_m.shape}")
    if not _is_pinhole(message.K):
        raise DecodeError(f"Frame.K: no pinhole camera: {message.K.tolist()}")
    if defect := rigid_defect(message.T_world_camera):
        raise DecodeError(f"Frame.T_world_camera: {defect}")
    return Frame(message.seq, message.stamp_ns, rgb, depth_m, message.K, message.T_world_camera)


def _pixels(image: ImageData, field: str, dtype: str, channels: int) -> Array:
    expected = 3 if channels == 3 else 2
    if image.dtype != dtype or len(image.shape) != expected:
        raise DecodeError(f"Frame.{field}: got {image.dtype!r:.20} of shape {image.shape}")
    try:
        return array_from_image(image)
    except DecodeError as error:
        raise DecodeError(f"Frame.{field}: {error}") from error


def _is_image_shape(shape: tuple[int, ...]) -> bool:
    return (
        len(shape) in (2, 3)
        and all(1 <= side <= MAX_SIDE_PX for side in shape[:2])
        and shape[2:] in ((), (3,))
    )


def _checked_size(image: ImageData) -> int:
    """Return the bytes of the pixels that dtype and shape promise."""
    if image.dtype not in _DTYPES or not _is_image_shape(image.shape):
        raise DecodeError(f"image: dtype {image.dtype!r:.20}, shape {image.shape!r:.60}")
    size_bytes = math.prod(image.shape) * np.dtype(image.dtype).itemsize
    if size_bytes > MAX_IMAGE_BYTES:
        raise DecodeError(f"image: {size_bytes} bytes, the limit is {MAX_IMAGE_BYTES}")
    return size_bytes


def _little_endian(array: Array) -> bytes:
    return array.astype(array.dtype.newbyteorder("<"), copy=False).tobytes()


def _from_raw(image: ImageData, data: bytes, size_bytes: int) -> Array:
    if len(data) != size_bytes:
        raise DecodeError(f"image: shape {image.shape} does not match {len(data)} bytes")
    return np.frombuffer(data, dtype=np.dtype(image.dtype)).reshape(image.shape)


def _decompress(data: bytes, size_bytes: int) -> bytes:
    """Return the content of one zstd frame whose header promises exactly ``size_bytes``."""
    try:
        promised = zstandard.get_frame_parameters(data).content_size
        if promised != size_bytes:
            raise DecodeError(f"image: zstd holds {promised} bytes, the shape needs {size_bytes}")
        return zstandard.ZstdDecompressor().decompress(data, allow_extra_data=False)
    except zstandard.ZstdError as error:
        raise DecodeError(f"image: not zstd: {error}") from error


def _from_jpeg(image: ImageData) -> Array:
    size = jpeg_size(image.data)
    if image.dtype != "|u1" or (*(size or ()), 3) != image.shape:
        raise DecodeError(f"image: JPEG of size {size}, the message says {image.shape}")
    try:
        return rgb_from_jpeg(image.data)
    except ValueError as error:
        raise DecodeError(f"image: {error}") from error


def _is_pinhole(K: Float64) -> bool:
    return bool(
        np.isfinite(K).all() and K[0, 0] > 0 and K[1, 1] > 0 and (K[2] == (0.0, 0.0, 1.0)).all()
    )
