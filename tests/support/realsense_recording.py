"""A recording of librealsense, by librealsense, of a camera that shows the slanted wall."""

import time
from pathlib import Path
from typing import Any

import numpy as np

from support.data_sets import units
from support.seven_scenes import SIZE, K, color


def record_realsense(rs: Any, path: Path, count: int, pause_s: float = 0.04) -> None:
    """Let librealsense record a software device that shows the wall.

    It is played at the pace at which it was recorded, ``pause_s`` an image.
    """
    device = rs.software_device()
    profiles = {}
    for name, kind, form, width in (
        ("Depth", rs.stream.depth, rs.format.z16, 2),
        ("Color", rs.stream.color, rs.format.rgb8, 3),
    ):
        sensor, stream, told = device.add_sensor(name), rs.video_stream(), rs.intrinsics()
        told.width, told.height = SIZE
        told.fx, told.fy, told.ppx, told.ppy = K[0, 0], K[1, 1], K[0, 2], K[1, 2]
        stream.type, stream.fmt, stream.bpp, stream.uid = kind, form, width, len(profiles)
        stream.width, stream.height, stream.fps, stream.intrinsics = *SIZE, 30, told
        profiles[name] = sensor, sensor.add_video_stream(stream), width
    profiles["Depth"][0].add_read_only_option(rs.option.depth_units, 0.001)
    still = rs.extrinsics()
    still.rotation, still.translation = np.eye(3).ravel().tolist(), [0, 0, 0]
    color_profile = profiles["Color"][1]
    profiles["Depth"][1].as_video_stream_profile().register_extrinsics_to(color_profile, still)
    recorder, queue = rs.recorder(str(path), device), rs.frame_queue(50, True)
    for sensor in recorder.query_sensors():
        sensor.open(sensor.get_stream_profiles()[0])
        sensor.start(queue)
    for number in range(count):
        for name, pixels in (("Depth", units(number, 1000)), ("Color", color(number))):
            sensor, profile, width = profiles[name]
            frame = rs.software_video_frame()
            frame.pixels, frame.stride, frame.bpp = pixels, SIZE[0] * width, width
            frame.timestamp, frame.frame_number = 1000.0 + 33.3 * number, number + 1
            frame.profile = profile.as_video_stream_profile()
            if name == "Depth":
                frame.depth_units = 0.001
            sensor.on_video_frame(frame)
            queue.wait_for_frame(1000)
        time.sleep(pause_s)
    for sensor in recorder.query_sensors():
        sensor.stop()
        sensor.close()
    recorder.pause()
