"""Images and their cameras at another size."""

import cv2
import numpy as np

from sceneq_core.arrays import UInt8
from sceneq_core.ingest.source import Camera
from sceneq_nodes._image_file import decode_rgb


def resized(camera: Camera, size: tuple[int, int]) -> Camera:
    """Return the camera of the image resized to (width, height).

    The centre of a pixel is a whole number.
    """
    scale = np.array(size) / np.array(camera.size)
    K = camera.K.copy()
    K[:2, :2] *= scale[:, None]
    K[:2, 2] = (camera.K[:2, 2] + 0.5) * scale - 0.5
    return Camera(K, size)


def decode_resized(data: bytes, size: tuple[int, int]) -> UInt8:
    """Return uint8 (H, W, 3) RGB of an image file, shrunk; ``ValueError`` as ``decode_rgb``."""
    return np.asarray(cv2.resize(decode_rgb(data), size, interpolation=cv2.INTER_AREA), np.uint8)
