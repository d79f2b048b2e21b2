"""An iPhone or iPad on USB that runs Record3D, through the package ``record3d``, with its poses.

ARKit on the phone knows where it is, so no odometry is needed; world is z up. Depth of a LiDAR has
a quarter of the resolution of colour. With the TrueDepth camera both images are mirrored back.
"""

import time
from dataclasses import dataclass
from threading import Lock
from typing import Any, ClassVar

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.source import Camera
from sceneq_core.ingest.transforms import rigid_defect
from sceneq_nodes._resized import resized
from sceneq_nodes.cameras.live_camera import (
    LiveCamera,
    LostError,
    Shot,
    camera_of,
    in_mm,
    need,
)
from sceneq_nodes.datasets.record3d_file import world_pose

TRUE_DEPTH = 0
"""Its device type; that of a LiDAR is 1."""
FIRST_S, POLL_S = 5.0, 0.02


@dataclass(frozen=True, slots=True)
class Record3dUsbParams:
    """``device``: which of several phones, from 0; ``min_confidence`` as of an .r3d file."""

    device: int = 0
    min_confidence: int = 1

    def __post_init__(self) -> None:
        if self.device < 0:
            raise ValueError(f"device: expected 0 or more, got {self.device}")
        if self.min_confidence not in (0, 1, 2):
            raise ValueError(f"min_confidence: expected 0, 1 or 2, got {self.min_confidence}")


class Record3dUsbSource(LiveCamera):
    """Frames of a phone."""

    Params: ClassVar[type] = Record3dUsbParams

    def __init__(self, params: Record3dUsbParams) -> None:
        super().__init__("record3d", lambda: Record3dUsbDevice(params), has_poses=True)


class Record3dUsbDevice:
    """A stream from a phone; images come on a thread of the package, the newest is kept."""

    def __init__(self, params: Record3dUsbParams) -> None:
        """Connect and wait for the first image; raise ``ValueError`` when there is none."""
        package = need("record3d", "record3d", "record3d-usb")
        phones = package.Record3DStream.get_connected_devices()
        if len(phones) <= params.device:
            hint = "open Record3D, Settings: Live RGBD Video Streaming USB, tap the red button"
            raise ValueError(f"record3d: {len(phones)} phones on USB ({hint})")
        self._least = params.min_confidence
        self._lock = Lock()
        self._newest: Shot | None = None
        self._cameras: tuple[Camera, Camera] | None = None
        self._is_stopped = False
        self._stream = package.Record3DStream()
        self._stream.on_new_frame = self._keep
        self._stream.on_stream_stopped = self._stop
        self._stream.connect(phones[params.device])
        self.color_camera, self.depth_camera = self._first()

    def take(self) -> Shot | None:
        """Return the newest shot."""
        with self._lock:
            shot, self._newest = self._newest, None
        if shot is None and self._is_stopped:
            raise LostError("record3d: the phone has stopped streaming")
        return shot

    def close(self) -> None:
        """Leave the phone alone."""
        self._stream.disconnect()

    def _first(self) -> tuple[Camera, Camera]:
        deadline_s = time.monotonic() + FIRST_S
        while self._cameras is None:
            if self._is_stopped or time.monotonic() > deadline_s:
                self.close()
                raise ValueError("record3d: the phone is there, but no image came")
            time.sleep(POLL_S)
        return self._cameras

    def _stop(self) -> None:
        self._is_stopped = True

    def _keep(self) -> None:
        """Copy what the package holds: it is written over by the next image."""
        stream, stamp_ns = self._stream, time.time_ns()
        rgb, depth_m = np.array(stream.get_rgb_frame()), np.array(stream.get_depth_frame())
        held = np.array(stream.get_confidence_frame())
        if held.shape == depth_m.shape:
            depth_m[held < self._least] = 0
        if stream.get_device_type() == TRUE_DEPTH:
            rgb, depth_m = rgb[:, ::-1].copy(), depth_m[:, ::-1].copy()
        pose = world_pose(_pose(stream.get_camera_pose()))
        shot = Shot(stamp_ns, rgb, in_mm(depth_m, 1000.0), pose)
        with self._lock:
            self._newest = None if rigid_defect(pose) else shot
        if self._cameras is None:
            self._cameras = _cameras(stream.get_intrinsic_mat(), rgb.shape, depth_m.shape)


def _pose(told: Any) -> Float64:
    names = ("qx", "qy", "qz", "qw", "tx", "ty", "tz")
    return np.array([getattr(told, name) for name in names], np.float64)


def _cameras(
    told: Any, rgb_shape: tuple[int, ...], depth_shape: tuple[int, ...]
) -> tuple[Camera, Camera]:
    color = camera_of(told.fx, told.fy, told.tx, told.ty, (rgb_shape[1], rgb_shape[0]))
    size = depth_shape[1], depth_shape[0]
    return color, color if size == color.size else resized(color, size)
