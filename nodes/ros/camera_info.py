"""Cameras as sensor_msgs/CameraInfo describes them."""

from typing import Any

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.undistortion import Lens
from sceneq_nodes.ros.typestore import WireError

ALIASES = {"": "plumb_bob", "fisheye": "equidistant", "none": "plumb_bob"}
RECTIFIED = "rect"


def lens(message: Any, is_rectified: bool) -> Lens:
    """Return the lens that took the images beside this message.

    Of rectified images it is the pinhole in ``p``: k and d still describe the camera before. With
    binning or a region of interest it is that of the pixels that are sent.

    Raises:
        WireError: there is no calibration in it, or an unusable one.
    """
    K = np.array(message.p if is_rectified else message.k, np.float64)
    K = K.reshape(3, 4)[:, :3] if is_rectified else K.reshape(3, 3)
    if not K.any():
        raise WireError("camera_info is all zeros: the camera is not calibrated")
    d = np.zeros(0) if is_rectified else np.array(message.d, np.float64)
    model = ALIASES.get(message.distortion_model, message.distortion_model)
    if not d.any() and model != "equidistant":
        model, d = "plumb_bob", np.zeros(5)
    size = int(message.width), int(message.height)
    try:
        return _sent(message, Lens(K, size, model, d))
    except ValueError as error:
        raise WireError(f"camera_info: {error}") from error


def is_rectified(topic: str) -> bool:
    """Tell it from the name, as image_pipeline gives it: ``image_rect``, ``image_rect_color``."""
    return any(RECTIFIED in part.split("_") for part in topic.split("/"))


def info_topic(image_topic: str) -> str:
    """Return where image_transport puts the camera_info of ``image_topic``: beside it."""
    base = image_topic
    for transport in ("/compressedDepth", "/compressed"):
        base = base.removesuffix(transport)
    return base.rpartition("/")[0] + "/camera_info"


def _sent(message: Any, whole: Lens) -> Lens:
    roi = message.roi
    binning = np.array([max(1, message.binning_x), max(1, message.binning_y)], np.float64)
    K: Float64 = whole.K.copy()
    K[:2, 2] -= (roi.x_offset, roi.y_offset)
    K[:2] /= binning[:, None]
    width, height = (roi.width, roi.height) if roi.width and roi.height else whole.size
    size = int(width // binning[0]), int(height // binning[1])
    return Lens(K, size, whole.model, whole.coefficients)
