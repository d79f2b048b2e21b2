"""A posed colour + depth image: the unit of input of the map."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32, Float64, UInt8, UInt16


@dataclass(frozen=True, slots=True)
class Frame:
    """Colour and depth of one instant in ONE pinhole camera (registered), with its pose.

    Attributes:
        seq: number of the source frame; joins every later message about it.
        stamp_ns: capture time, nanoseconds.
        rgb: uint8 (H, W, 3), RGB.
        depth_m: float32 (H, W), metres along the optical axis, 0 = no measurement.
        K: float64 (3, 3), pixels.
        T_world_camera: float64 (4, 4), p_world = T_world_camera @ p_camera, metres, OpenCV axes.
    """

    seq: int
    stamp_ns: int
    rgb: UInt8
    depth_m: Float32
    K: Float64
    T_world_camera: Float64


def depth_from_mm(depth_mm: UInt16) -> Float32:
    """Return metres from millimetres; the one place, so that every path gets the same floats."""
    return depth_mm.astype(np.float32) * np.float32(0.001)


def depth_to_mm(depth_m: Float32) -> UInt16:
    """Return whole millimetres; the exact inverse of ``depth_from_mm``."""
    depth_mm: UInt16 = np.rint(depth_m * np.float32(1000.0)).astype(np.uint16)
    return depth_mm
