"""Images of ROS 2 as colour in RGB and depth in millimetres.

Functions take decoded messages (anything with their attributes), so bags may use them too.
"""

import struct
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np

from sceneq_core.arrays import Array, Float32, UInt8, UInt16
from sceneq_nodes._image_file import decode_depth_mm, decode_rgb, header
from sceneq_nodes._rvl import decode_rvl
from sceneq_nodes.ros.typestore import WireError

MM_PER_M = 1000.0
MAX_MM = np.iinfo(np.uint16).max
COMPRESSED_DEPTH = struct.Struct("<iff")
"""The header of compressed_depth_image_transport: format, quantisation A and B."""

RVL_SIZE = struct.Struct("<ii")

_Convert = Callable[[Array], Array]


def _code(code: int) -> _Convert:
    return lambda image: np.asarray(cv2.cvtColor(image, code))


def _high_byte(image: Array) -> Array:
    return _grey((image >> 8).astype(np.uint8))


def _grey(image: Array) -> Array:
    return np.repeat(image[..., None], 3, axis=2)


COLOUR: dict[str, tuple[type, int, _Convert]] = {
    "rgb8": (np.uint8, 3, lambda image: image),
    "bgr8": (np.uint8, 3, lambda image: image[..., ::-1]),
    "8UC3": (np.uint8, 3, lambda image: image[..., ::-1]),
    "rgba8": (np.uint8, 4, lambda image: image[..., :3]),
    "bgra8": (np.uint8, 4, lambda image: image[..., 2::-1]),
    "8UC4": (np.uint8, 4, lambda image: image[..., 2::-1]),
    "mono8": (np.uint8, 1, _grey),
    "8UC1": (np.uint8, 1, _grey),
    "mono16": (np.uint16, 1, _high_byte),
    "yuv422": (np.uint8, 2, _code(cv2.COLOR_YUV2RGB_UYVY)),
    "uyvy": (np.uint8, 2, _code(cv2.COLOR_YUV2RGB_UYVY)),
    "yuv422_yuy2": (np.uint8, 2, _code(cv2.COLOR_YUV2RGB_YUY2)),
    "yuyv": (np.uint8, 2, _code(cv2.COLOR_YUV2RGB_YUY2)),
}
"""Encoding -> type and channels of its pixels, and what makes RGB of them."""
DEPTH: dict[str, type] = {"16UC1": np.uint16, "mono16": np.uint16, "32FC1": np.float32}


def image_rgb(message: Any) -> UInt8:
    """Return uint8 (H, W, 3) RGB of a sensor_msgs/Image.

    Raises:
        WireError: another encoding, or fewer bytes than the image needs.
    """
    if message.encoding not in COLOUR:
        known = ", ".join(COLOUR)
        raise WireError(f"colour of encoding '{message.encoding}' (known: {known})")
    kind, channels, convert = COLOUR[message.encoding]
    return np.ascontiguousarray(convert(_pixels(message, kind, channels)), np.uint8)


def image_depth_mm(message: Any) -> UInt16:
    """Return uint16 (H, W) millimetres, 0 = no measurement, of a sensor_msgs/Image (REP 118).

    Raises:
        WireError: as above.
    """
    if message.encoding not in DEPTH:
        known = ", ".join(DEPTH)
        raise WireError(f"depth of encoding '{message.encoding}' (known: {known})")
    pixels = _pixels(message, DEPTH[message.encoding], 1)
    if pixels.dtype == np.float32:
        return depth_mm_of_metres(pixels)
    return np.where(pixels == MAX_MM, 0, pixels).astype(np.uint16)


def compressed_rgb(message: Any) -> UInt8:
    """Return uint8 (H, W, 3) RGB of a sensor_msgs/CompressedImage that holds JPEG or PNG.

    Raises:
        WireError: it does not decode.
    """
    data = bytes(message.data)
    return np.asarray(_decoded(lambda: (header(data), decode_rgb(data))[1], message), np.uint8)


def compressed_depth_mm(message: Any) -> UInt16:
    """Return uint16 (H, W) millimetres of a sensor_msgs/CompressedImage.

    ``...; compressedDepth`` (12 bytes, then PNG or RVL; metres as quantised inverse depth), or a
    plain PNG of 16 bits.

    Raises:
        WireError: it does not decode.
    """
    data = bytes(message.data)
    if "compressedDepth" not in message.format:
        return np.asarray(_decoded(lambda: _png(data), message))
    if len(data) < COMPRESSED_DEPTH.size:
        raise WireError(f"depth of format '{message.format}': only {len(data)} bytes")
    _, a, b = COMPRESSED_DEPTH.unpack_from(data)
    decode = _rvl if "rvl" in message.format.lower() else _png
    values = _decoded(lambda: decode(data[COMPRESSED_DEPTH.size :]), message)
    if message.format.partition(";")[0].strip() != "32FC1":
        return np.asarray(values, np.uint16)
    with np.errstate(invalid="ignore", over="ignore"):
        scaled = values.astype(np.float32) - np.float32(b)
        measured = (values > 0) & (scaled > 0)
        depth_m = np.where(measured, np.float32(a) / np.where(measured, scaled, 1), 0)
    return depth_mm_of_metres(depth_m)


def depth_mm_of_metres(depth_m: Float32) -> UInt16:
    """Return millimetres; what is not finite, negative or out of 16 bits is no measurement."""
    with np.errstate(invalid="ignore", over="ignore"):
        depth_mm = np.rint(depth_m * np.float32(MM_PER_M))
        measured = (depth_mm > 0) & (depth_mm < MAX_MM)
    return np.where(measured, depth_mm, 0).astype(np.uint16)


def _png(data: bytes) -> UInt16:
    """Decode what is whole and no larger than an image may be."""
    header(data)
    return decode_depth_mm(data)


def _rvl(data: bytes) -> UInt16:
    if len(data) < RVL_SIZE.size:
        raise ValueError(f"only {len(data)} bytes")
    depth_mm = decode_rvl(data[RVL_SIZE.size :], RVL_SIZE.unpack_from(data))
    depth_mm[depth_mm == MAX_MM] = 0
    return depth_mm


def _decoded(decode: Callable[[], Array], message: Any) -> Array:
    try:
        return decode()
    except (ValueError, cv2.error) as error:
        raise WireError(f"image of format '{message.format}': {error}") from error


def _pixels(message: Any, kind: type, channels: int) -> Array:
    """Return (H, W) or (H, W, channels) in the byte order of this machine, padding left out."""
    item = np.dtype(kind).newbyteorder(">" if message.is_bigendian else "<")
    height, width, step = int(message.height), int(message.width), int(message.step)
    row = width * channels * item.itemsize
    data = np.frombuffer(message.data, np.uint8)
    if not (width and height) or step < row or len(data) < step * (height - 1) + row:
        wanted = f"{width}x{height} {message.encoding} with step {step}"
        raise WireError(f"{wanted} needs more than {len(data)} bytes")
    lines = np.lib.stride_tricks.as_strided(data, (height, row), (step, 1), writeable=False)
    shape = (height, width) if channels == 1 else (height, width, channels)
    pixels = np.ascontiguousarray(lines).view(item).reshape(shape)
    return pixels.astype(item.newbyteorder("="), copy=False)
