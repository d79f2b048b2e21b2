"""A Luxonis OAK-D camera through ``depthai`` 3: stereo depth aligned to the colour camera.

The camera undistorts its colour images itself, and joins them with depth.
"""

from dataclasses import dataclass
from datetime import timedelta
from typing import Any, ClassVar

import numpy as np

from sceneq_nodes.cameras.live_camera import (
    CameraParams,
    LiveCamera,
    LostError,
    Shot,
    camera_of,
    in_mm,
    need,
)

STEREO_SIZE = (640, 400)
MAX_APART = timedelta(milliseconds=20)


@dataclass(frozen=True, slots=True)
class OakParams(CameraParams):
    """As of every camera; ``serial`` is its MXID, or its IP address."""


class OakSource(LiveCamera):
    """Frames of an OAK-D camera."""

    Params: ClassVar[type] = OakParams

    def __init__(self, params: OakParams) -> None:
        super().__init__("oak", lambda: OakDevice(params))


class OakDevice:
    """A running pipeline."""

    def __init__(self, params: OakParams) -> None:
        """Start it; raise ``ValueError`` when there is no camera."""
        dai = need("depthai", "depthai", "oak")
        size = params.width, params.height
        try:
            device = dai.Device(dai.DeviceInfo(params.serial)) if params.serial else dai.Device()
            self._pipeline = dai.Pipeline(device)
            self._queue = _images(dai, self._pipeline, params)
            color = dai.CameraBoardSocket.CAM_A
            K = np.array(device.readCalibration().getCameraIntrinsics(color, *size), np.float64)
            self._pipeline.start()
        except RuntimeError as error:
            hint = "plugged in? udev rules of depthai installed?"
            raise ValueError(f"oak: {error} ({hint})") from error
        self.color_camera = camera_of(K[0, 0], K[1, 1], K[0, 2], K[1, 2], size)
        self.depth_camera = self.color_camera

    def take(self) -> Shot | None:
        """Return the newest pair of images, if one has come."""
        try:
            pair = self._queue.tryGet()
        except RuntimeError as error:  # the queue is closed when the link is gone
            raise LostError(f"oak: {error}") from error
        if pair is None:
            return None
        color, depth = pair["color"], pair["depth"]
        rgb = np.ascontiguousarray(color.getCvFrame()[..., ::-1])
        stamp_ns = round(color.getTimestamp().total_seconds() * 1e9)
        return Shot(stamp_ns, rgb, in_mm(np.asarray(depth.getFrame()), 1.0))

    def close(self) -> None:
        """Stop the pipeline."""
        try:
            self._pipeline.stop()
        except RuntimeError as error:
            raise LostError(str(error)) from error


def _images(dai: Any, pipeline: Any, params: OakParams) -> Any:
    """Return the queue of pairs, the newest one only."""
    sockets, size = dai.CameraBoardSocket, (params.width, params.height)
    color = pipeline.create(dai.node.Camera).build(sockets.CAM_A)
    of_color = color.requestOutput(
        size, type=dai.ImgFrame.Type.BGR888i, fps=params.fps, enableUndistortion=True
    )
    stereo = pipeline.create(dai.node.StereoDepth)
    for socket, side in ((sockets.CAM_B, stereo.left), (sockets.CAM_C, stereo.right)):
        eye = pipeline.create(dai.node.Camera).build(socket)
        eye.requestOutput(STEREO_SIZE, fps=params.fps).link(side)
    of_color.link(stereo.inputAlignTo)
    pair = pipeline.create(dai.node.Sync)
    pair.setSyncThreshold(MAX_APART)
    of_color.link(pair.inputs["color"])
    stereo.depth.link(pair.inputs["depth"])
    return pair.out.createOutputQueue(maxSize=1, blocking=False)
