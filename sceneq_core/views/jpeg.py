"""Colour as JPEG in memory; the only place that knows OpenCV wants BGR."""

import cv2
import numpy as np

from sceneq_core.arrays import Float32, UInt8

QUALITY = 90
"""Crops at 90 keep the classifier's answer; an image of 640x480 takes 60-80 KB."""

MAX_PIXELS = 1 << 25
"""8K: a header of a few bytes may not claim more memory than its pixels, 100 MB."""

_SIZE_MARKERS = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}


def jpeg_from_rgb(rgb: UInt8) -> bytes:
    """Return uint8 (H, W, 3) RGB as JPEG; raise ``ValueError`` on anything else."""
    if rgb.dtype != np.uint8 or rgb.ndim != 3 or rgb.shape[2] != 3:
        raise ValueError(f"JPEG carries colour: dtype {rgb.dtype}, shape {rgb.shape}")
    bgr = cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2BGR)
    encoded: UInt8 = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1]
    return encoded.tobytes()


def rgb_from_jpeg(data: bytes) -> UInt8:
    """Return uint8 (H, W, 3) RGB; raise ``ValueError`` when ``data`` is no complete JPEG."""
    flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
    height, width = jpeg_size(data) or (0, 0)
    if height * width > MAX_PIXELS:
        raise ValueError(f"JPEG of {width} x {height} pixels, the limit is {MAX_PIXELS}")
    bgr = cv2.imdecode(np.frombuffer(data, np.uint8), flags) if height * width else None
    if bgr is None:
        raise ValueError(f"{len(data)} bytes are no JPEG")
    return np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8)


def with_box(jpeg: bytes, box_xyxy: Float32) -> bytes:
    """Return the image with a box (4,) in pixels drawn on it, dark inside bright for any ground.

    Raises:
        ValueError: no JPEG, or a box that is not finite.
    """
    if not np.isfinite(box_xyxy).all():
        raise ValueError(f"box {box_xyxy.tolist()} is not finite")
    rgb = rgb_from_jpeg(jpeg)
    height, width = rgb.shape[:2]
    x0, y0, x1, y1 = np.clip(box_xyxy, 0, [width, height, width, height]).astype(int).tolist()
    for colour, thickness in (((255, 210, 0), 4), ((40, 40, 40), 1)):
        cv2.rectangle(rgb, (x0, y0), (x1 - 1, y1 - 1), colour, thickness)
    return jpeg_from_rgb(rgb)


def jpeg_size(data: bytes) -> tuple[int, int] | None:
    """Return (height, width) from the header alone, ``None`` when it is no complete JPEG.

    So a header that lies about its size can be refused before anything is allocated.
    """
    if data[:2] != b"\xff\xd8" or data[-2:] != b"\xff\xd9":
        return None
    at = 2
    while at + 9 <= len(data) and data[at] == 0xFF:
        if data[at + 1] in _SIZE_MARKERS:
            return _big_endian(data, at + 5), _big_endian(data, at + 7)
        at += 2 + max(_big_endian(data, at + 2), 2)
    return None


def _big_endian(data: bytes, at: int) -> int:
    return int.from_bytes(data[at : at + 2], "big")
