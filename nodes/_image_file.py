"""Image files, checked before they are decoded.

OpenCV decodes a file that was cut off into a half-grey image and says nothing. Whether a file is
complete can be read from its structure, and much faster than by decoding it.
"""

import zlib
from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Array, UInt8, UInt16

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
PNG_CHANNELS = {0: 1, 2: 3, 3: 3, 4: 2, 6: 4}
"""Colour type -> channels; a palette (3) holds RGB."""
JPEG_START, JPEG_SCAN, JPEG_END = b"\xff\xd8", 0xDA, b"\xff\xd9"
JPEG_SIZES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
MAX_PIXELS = 1 << 25
"""8K: a header of a few bytes may not claim more memory than these pixels take."""
INVALID_DEPTH = 65535
"""What the 7-Scenes recordings write where there was no measurement; ours is 0."""


@dataclass(frozen=True, slots=True)
class Header:
    """``size`` is (width, height); ``bits`` are per channel."""

    size: tuple[int, int]
    bits: int
    channels: int

    @property
    def is_depth(self) -> bool:
        """Tell a depth image, 16 bits grey, from colour."""
        return self.bits == 16 and self.channels == 1


def header(data: bytes) -> Header:
    """Return what a complete PNG or JPEG file holds; raise ``ValueError`` on anything else."""
    if data.startswith(PNG_SIGNATURE):
        found = _png_header(data)
    elif data.startswith(JPEG_START):
        found = _jpeg_header(data)
    else:
        raise ValueError("neither PNG nor JPEG" if data else "empty file")
    width, height = found.size
    if width * height > MAX_PIXELS:
        raise ValueError(f"{width} x {height} pixels, the limit is {MAX_PIXELS}")
    return found


def decode_rgb(data: bytes) -> UInt8:
    """Return uint8 (H, W, 3) RGB; raise ``ValueError`` when the file does not decode."""
    flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
    bgr: Array | None = cv2.imdecode(np.frombuffer(data, np.uint8), flags)
    if bgr is None:
        raise ValueError("colour does not decode")
    return np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), dtype=np.uint8)


def decode_depth_mm(data: bytes) -> UInt16:
    """Return uint16 (H, W) millimetres, 0 = no measurement; ``ValueError`` as above."""
    depth_mm: Array | None = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    if depth_mm is None or depth_mm.dtype != np.uint16 or depth_mm.ndim != 2:
        raise ValueError("depth does not decode to uint16 (H, W)")
    depth_mm[depth_mm == INVALID_DEPTH] = 0
    return depth_mm


def _png_header(data: bytes) -> Header:
    at, kind = len(PNG_SIGNATURE), b""
    while kind != b"IEND":
        length, kind = _number(data, at, 4), data[at + 4 : at + 8]
        end = at + 8 + length
        if len(data) < end + 4:
            raise ValueError(f"PNG is cut off after {len(data)} bytes")
        if zlib.crc32(memoryview(data)[at + 4 : end]) != _number(data, end, 4):
            raise ValueError(f"PNG is damaged at byte {at}")
        at = end + 4
    if len(data) < 33 or data[25] not in PNG_CHANNELS:
        raise ValueError("PNG is damaged in its header")
    size = _number(data, 16, 4), _number(data, 20, 4)
    return Header(size, bits=data[24], channels=PNG_CHANNELS[data[25]])


def _jpeg_header(data: bytes) -> Header:
    """Walk the segments up to the first scan; the end marker must come after it."""
    at, size, bits, channels = 2, None, 0, 0
    while at + 10 <= len(data) and data[at] == 0xFF and data[at + 1] != JPEG_SCAN:
        if data[at + 1] in JPEG_SIZES:
            size = _number(data, at + 7, 2), _number(data, at + 5, 2)
            bits, channels = data[at + 4], data[at + 9]
        at += 2 + max(2, _number(data, at + 2, 2))
    if size is None or data[at : at + 2] != bytes((0xFF, JPEG_SCAN)):
        raise ValueError("JPEG is damaged in its header")
    if data.rfind(JPEG_END, at) < 0:
        raise ValueError(f"JPEG is cut off after {len(data)} bytes")
    return Header(size, bits, channels)


def _number(data: bytes, at: int, length: int) -> int:
    return int.from_bytes(data[at : at + length], "big")
