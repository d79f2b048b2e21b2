"""An Orbbec camera (Gemini, Femto, Astra), or what it recorded, through ``pyorbbecsdk``.

The package is called ``pyorbbecsdk2`` for version 2 of the SDK, ``pyorbbecsdk`` for version 1; the
module is the same. Depth is aligned to colour by the SDK, and the distortion of colour undone.
"""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from sceneq_core.arrays import UInt8
from sceneq_core.ingest.undistortion import Lens, Undistortion
from sceneq_nodes._image_file import decode_rgb
from sceneq_nodes.cameras.live_camera import (
    CameraParams,
    LiveCamera,
    LostError,
    Shot,
    camera_of,
    in_mm,
    need,
)

WAIT_MS = 5
COEFFICIENTS = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")


@dataclass(frozen=True, slots=True)
class OrbbecParams(CameraParams):
    """As of every camera."""


class OrbbecSource(LiveCamera):
    """Frames of an Orbbec camera."""

    Params: ClassVar[type] = OrbbecParams

    def __init__(self, params: OrbbecParams) -> None:
        super().__init__("orbbec", lambda: OrbbecDevice(params))


class OrbbecDevice:
    """A running pipeline."""

    def __init__(self, params: OrbbecParams) -> None:
        """Start it; raise ``ValueError`` when there is no camera, or none that can do this."""
        self._sdk = ob = need("pyorbbecsdk", "pyorbbecsdk2", "orbbec")
        try:
            self._pipeline = _pipeline(ob, params.serial)
            config = ob.Config()
            color = self._pipeline.get_stream_profile_list(ob.OBSensorType.COLOR_SENSOR)
            depth = self._pipeline.get_stream_profile_list(ob.OBSensorType.DEPTH_SENSOR)
            size = params.width, params.height
            config.enable_stream(color.get_video_stream_profile(*size, ob.OBFormat.RGB, params.fps))
            config.enable_stream(depth.get_default_video_stream_profile())
            self._pipeline.enable_frame_sync()
            self._pipeline.start(config)
            told = self._pipeline.get_camera_param()
        except Exception as error:  # the SDK raises OBError or RuntimeError, by version
            hint = "plugged in? udev rules of the SDK installed? does it have that resolution?"
            raise ValueError(f"orbbec: {error} ({hint})") from error
        self._align = ob.AlignFilter(ob.OBStreamType.COLOR_STREAM)
        K = told.rgb_intrinsic
        self.color_camera = camera_of(K.fx, K.fy, K.cx, K.cy, (K.width, K.height))
        self.depth_camera = self.color_camera
        d = np.array([getattr(told.rgb_distortion, name) for name in COEFFICIENTS], np.float64)
        lens = Lens(self.color_camera.K, self.color_camera.size, "rational_polynomial", d)
        self._undistortion = Undistortion(lens)

    def take(self) -> Shot | None:
        """Return the next pair of images, if one has come."""
        try:
            frames = self._pipeline.wait_for_frames(WAIT_MS)
            aligned = None if frames is None else self._align.process(frames)
        except Exception as error:
            raise LostError(f"orbbec: {error}") from error
        if aligned is None:
            return None
        frames = aligned.as_frame_set()
        color, depth = frames.get_color_frame(), frames.get_depth_frame()
        if color is None or depth is None:
            return None
        size = depth.get_height(), depth.get_width()
        units = np.frombuffer(depth.get_data(), np.uint16).reshape(size)
        depth_mm = in_mm(units, float(depth.get_depth_scale()))
        straight = self._undistortion
        return Shot(
            1000 * int(color.get_timestamp_us()),
            straight.rgb(self._rgb(color)),
            straight.depth_mm(depth_mm),
        )

    def close(self) -> None:
        """Stop the pipeline."""
        try:
            self._pipeline.stop()
        except Exception as error:
            raise LostError(str(error)) from error

    def _rgb(self, frame: Any) -> UInt8:
        data = np.frombuffer(frame.get_data(), np.uint8)
        if frame.get_format() == self._sdk.OBFormat.MJPG:
            return decode_rgb(data.tobytes())
        return data.reshape(frame.get_height(), frame.get_width(), 3).copy()


def _pipeline(ob: Any, serial: str) -> Any:
    if not serial:
        return ob.Pipeline()
    return ob.Pipeline(ob.Context().query_devices().get_device_by_serial_number(serial))
