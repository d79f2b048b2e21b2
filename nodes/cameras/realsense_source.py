"""An Intel RealSense camera (D400, L500), or what it recorded, through ``pyrealsense2``.

Depth is aligned to colour by the library. A D400 tells of no distortion of its colour images (its
model is of rectified ones); if it does, that is undone.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from sceneq_core.ingest.undistortion import Lens, Undistortion
from sceneq_nodes.cameras.live_camera import (
    CameraParams,
    LiveCamera,
    LostError,
    Shot,
    camera_of,
    in_mm,
    need,
)

MAX_APART_MS = 20.0
WAIT_MS = 5


@dataclass(frozen=True, slots=True)
class RealsenseParams(CameraParams):
    """As of every camera; ``playback``: a file of realsense-viewer in its place, at its pace.

    ``lossless``: as fast as images are taken instead, and every one of them.
    """

    playback: str = ""
    lossless: bool = False

    def __post_init__(self) -> None:
        CameraParams.__post_init__(self)
        if self.lossless and not self.playback:
            raise ValueError("lossless: a camera does not wait; for a playback only")


class RealsenseSource(LiveCamera):
    """Frames of a RealSense camera."""

    Params: ClassVar[type] = RealsenseParams

    def __init__(self, params: RealsenseParams) -> None:
        super().__init__("realsense", lambda: RealsenseDevice(params))


class RealsenseDevice:
    """A running pipeline."""

    def __init__(self, params: RealsenseParams) -> None:
        """Start it; raise ``ValueError`` when there is no camera, or none that can do this."""
        rs = need("pyrealsense2", "pyrealsense2", "realsense")
        if params.playback and not Path(params.playback).is_file():
            raise ValueError(f"playback: no file {params.playback}")
        self._pipeline, config = rs.pipeline(), _config(rs, params)
        try:
            profile = self._started(config, lossless=params.lossless)
            depth_sensor = profile.get_device().first_depth_sensor()
            self._mm_per_unit = round(1000.0 * depth_sensor.get_depth_scale(), 6)
            color = profile.get_stream(rs.stream.color).as_video_stream_profile()
            told = color.get_intrinsics()
        except RuntimeError as error:
            hint = "plugged in, on USB 3, and nobody else's? rs-enumerate-devices lists modes"
            raise ValueError(f"realsense: {error} ({hint})") from error
        self._align = rs.align(rs.stream.color)
        self.color_camera = camera_of(
            told.fx, told.fy, told.ppx, told.ppy, (told.width, told.height)
        )
        self.depth_camera = self.color_camera
        self._lens = _lens(rs, told, self.color_camera.K)

    def _started(self, config: Any, *, lossless: bool) -> Any:
        """Start the streams; what is played waits until all of them can take images."""
        if not lossless:
            return self._pipeline.start(config)
        playback = config.resolve(self._pipeline).get_device().as_playback()
        playback.set_real_time(False)
        playback.pause()
        profile = self._pipeline.start(config)
        playback.resume()
        return profile

    def take(self) -> Shot | None:
        """Return the newest pair of images, if one has come."""
        try:
            came, frames = self._pipeline.try_wait_for_frames(WAIT_MS)
            if not came:
                return None
            aligned = self._align.process(frames)
        except RuntimeError as error:
            raise LostError(f"realsense: {error}") from error
        color, depth = aligned.get_color_frame(), aligned.get_depth_frame()
        if not (color and depth):
            return None
        if abs(color.get_timestamp() - depth.get_timestamp()) > MAX_APART_MS:
            return None  # a frameset holds the last of each: the other half comes next
        rgb, units = (np.array(frame.get_data()) for frame in (color, depth))
        depth_mm = in_mm(units, self._mm_per_unit)
        if self._lens is not None:
            rgb, depth_mm = self._lens.rgb(rgb), self._lens.depth_mm(depth_mm)
        return Shot(round(1e6 * color.get_timestamp()), rgb, depth_mm)

    def close(self) -> None:
        """Stop the pipeline."""
        try:
            self._pipeline.stop()
        except RuntimeError as error:
            raise LostError(str(error)) from error


def _config(rs: Any, params: RealsenseParams) -> Any:
    config = rs.config()
    if params.playback:
        config.enable_device_from_file(params.playback, False)
        return config
    if params.serial:
        config.enable_device(params.serial)
    size = params.width, params.height
    config.enable_stream(rs.stream.color, *size, rs.format.rgb8, params.fps)
    config.enable_stream(rs.stream.depth, *size, rs.format.z16, params.fps)
    return config


def _lens(rs: Any, told: Any, K: Any) -> Undistortion | None:
    """Return what undoes the distortion; the inverse model is that of rectified images."""
    coefficients = np.array(told.coeffs, np.float64)
    models = (rs.distortion.brown_conrady, rs.distortion.modified_brown_conrady)
    if told.model not in models or not coefficients.any():
        return None
    return Undistortion(Lens(K, (told.width, told.height), "plumb_bob", coefficients))
