"""An RGB-D camera: what a perfect picture becomes in it."""

import numpy as np

from sceneq_core.arrays import UInt8, UInt16
from sceneq_tools.room.camera.colour_sensor import ColourSensor, Motion
from sceneq_tools.room.camera.depth_sensor import DepthSensor
from sceneq_tools.room.rendering import Rendering

__all__ = ["ColourSensor", "DepthSensor", "Motion", "measure"]


def measure(
    rendering: Rendering,
    rng: np.random.Generator,
    depth: DepthSensor | None = None,
    colour: ColourSensor | None = None,
    motion: Motion | None = None,
) -> tuple[UInt8, UInt16]:
    """Return sRGB uint8 (H, W, 3) and depth uint16 (H, W) in millimetres, 0 = no measurement.

    The same rendering and state of ``rng`` give the same bytes.
    """
    depth_mm = (depth or DepthSensor()).measure(rendering, rng)
    return (colour or ColourSensor()).measure(rendering, rng, motion), depth_mm
