"""What shines in a room: windows, the ceiling lamp, and lamps that stand about."""

from collections.abc import Iterable

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_tools.room.layout.probe import bounds
from sceneq_tools.room.mesh import Colour
from sceneq_tools.room.room import Light, Thing

DAYLIGHT: Colour = (0.80, 0.92, 1.08)
WARM: Colour = (1.0, 0.84, 0.66)
SKY_RADIANCE = 7.5
"""Of the sky seen through a window, against a well-exposed wall of about 1."""

CEILING_RADIANCE = 14.0
CEILING_SIDE_M = 0.5

LAMP_RADIANCE = 30.0
LAMP_SIDE_M = 0.14
"""A bulb below a shade: small, so that its light falls off around it."""

LAMPS = ("floor lamp", "table lamp", "desk lamp")
SHADE_SHARE = 0.72
"""Height of the lower edge of a lamp's shade, as a share of the lamp's."""

MOST_LAMPS = 2
"""Every light costs rendering time, and more than these are not noticed."""


def lights_of(things: Iterable[Thing]) -> tuple[Light, ...]:
    """Return the lights that a room's things give, windows first."""
    things = tuple(things)
    lamps = [_lamp(thing) for thing in things if thing.label in LAMPS]
    windows = (_window(thing) for thing in things if thing.label == "window")
    ceiling = (_ceiling_lamp(thing) for thing in things if thing.label == "ceiling lamp")
    return (*windows, *ceiling, *lamps[:MOST_LAMPS])


def _window(thing: Thing) -> Light:
    """Shine inwards (-y of the window) from the plane of the wall."""
    low, high = bounds(thing.mesh)
    brightness = max(material.emission for material in thing.mesh.materials)
    size = high - low
    return _light(
        thing,
        np.array([low[0], 0.02, low[2]]),
        np.array([size[0], 0, 0]),
        np.array([0, 0, size[2]]),
        _times(DAYLIGHT, SKY_RADIANCE * brightness),
    )


def _ceiling_lamp(thing: Thing) -> Light:
    side = CEILING_SIDE_M
    corner = np.array([-side / 2, -side / 2, -0.015])
    return _downwards(thing, corner, side, _times(WARM, CEILING_RADIANCE))


def _lamp(thing: Thing) -> Light:
    low, high = bounds(thing.mesh)
    middle = (low + high) / 2
    side = LAMP_SIDE_M
    z = low[2] + SHADE_SHARE * (high[2] - low[2])
    corner = np.array([middle[0] - side / 2, middle[1] - side / 2, z])
    return _downwards(thing, corner, side, _times(WARM, LAMP_RADIANCE))


def _downwards(thing: Thing, corner: Float64, side: float, radiance: Colour) -> Light:
    return _light(thing, corner, np.array([0, side, 0.0]), np.array([side, 0, 0.0]), radiance)


def _light(
    thing: Thing, corner: Float64, edge_u: Float64, edge_v: Float64, radiance: Colour
) -> Light:
    T_world = thing.T_world_thing
    R_world = T_world[:3, :3]
    return Light(R_world @ corner + T_world[:3, 3], R_world @ edge_u, R_world @ edge_v, radiance)


def _times(colour: Colour, factor: float) -> Colour:
    return (colour[0] * factor, colour[1] * factor, colour[2] * factor)
