"""The boxed room, changed: something moves, something goes, something comes."""

from dataclasses import replace

import numpy as np

from sceneq_tools.room.room import Room

from support.boxed_room import placed, thing


def edited(room: Room) -> Room:
    """The mug moves to the coffee table, the book goes, a vase comes."""
    mug = replace(room.thing(8), T_world_thing=placed(2.5, 2.0, 0.42, np.pi / 2), support=10)
    vase = thing(14, "vase", "top", (0.2, 0.2, 0.4), placed(2.2, 2.0, 0.42), 10)
    others = tuple(t for t in room.things if t.id not in (8, 9))
    return replace(room, things=(*others, mug, vase))
