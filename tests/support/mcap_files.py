"""Writes recordings of a camera that turns before the wall of ``seven_scenes``."""

from pathlib import Path

import numpy as np

from sceneq_core.frame import Frame
from sceneq_nodes._images import frame_message
from sceneq_nodes.recording import forms
from sceneq_nodes.recording.mcap_writer import McapWriter
from sceneq_schemas.frame import Pose

from support.seven_scenes import K, color, depth_mm

STEP_NS = 300_000_000


def turned(angle: float) -> np.ndarray:
    """A pose whose quaternion would not give it back to the last bit."""
    T_world_camera = np.eye(4)
    c, s = np.cos(angle), np.sin(angle)
    T_world_camera[:3, :3] = [[c, -s, 0], [s, c, 0], [0, 0, 1]]
    T_world_camera[:3, 3] = np.pi, -angle, 1 / 3
    return T_world_camera @ np.eye(4)  # as ingest does; it makes 0 of -0


def frame(number: int) -> Frame:
    depth = np.where(depth_mm(number) == 65535, 0, depth_mm(number))
    depth_m = depth.astype(np.float32) * np.float32(0.001)
    stamp_ns = 7_000_000_001 + STEP_NS * number
    return Frame(3 * number, stamp_ns, color(number), depth_m, K, turned(0.1 * number))


def write_mcap(
    path: Path,
    count: int = 5,
    rgb_codec: str = "raw",
    close: bool = True,
    without_depth: int | None = None,
) -> McapWriter:
    """Write keyframes 0, 3, 6, ...; that of number ``without_depth`` is not complete."""
    writer = McapWriter(path)
    for number in range(count):
        for said in forms.keyframe_said(frame_message(frame(number), rgb_codec, "zstd")):
            if number != without_depth or said.topic != forms.DEPTH:
                writer.write(said)
        of = frame(number)
        writer.write(forms.pose_said(Pose(of.seq, of.stamp_ns, of.T_world_camera, "given", True)))
        writer.flush()
    if close:
        writer.close()
    return writer
