"""Whether people can walk through a furnished room."""

import cv2
import numpy as np

from sceneq_core.arrays import Bool, UInt8
from sceneq_tools.room.layout.draft import DOORWAY_M, Draft
from sceneq_tools.room.layout.fittings import DOOR
from sceneq_tools.room.layout.placement import footprint, front_area, heights

CELL_M = 0.05
BODY_M = 0.22
"""Half the width of somebody who squeezes past a table."""

HEAD_M = 1.9
"""What hangs higher is in nobody's way."""

CONNECTED_SHARE = 0.7
"""So much of the free floor has to be reached from the door: a corner may be cut off."""

LEAST_SHARE = 0.08
"""So much of the whole floor, or there is no room to turn in."""


def is_walkable(draft: Draft) -> bool:
    """Tell whether most of the free floor can be reached from the door."""
    free = _free(draft)
    _, region = cv2.connectedComponents(free.astype(np.uint8), connectivity=4)
    reached = region == _region_at_door(draft, region)
    reached &= free
    return bool(reached.sum() >= CONNECTED_SHARE * free.sum() and reached.mean() >= LEAST_SHARE)


def _free(draft: Draft) -> Bool:
    """Return the cells (y, x) where somebody's middle may be."""
    width, depth, _ = draft.size_m
    shape = (round(depth / CELL_M), round(width / CELL_M))
    taken: UInt8 = np.zeros(shape, np.uint8)
    edge = round(BODY_M / CELL_M)
    taken[:edge], taken[-edge:], taken[:, :edge], taken[:, -edge:] = 1, 1, 1, 1
    for thing in draft.furniture():
        low, high = heights(thing.mesh, thing.T_world_thing)
        if low < HEAD_M and high > 0.1:
            area = footprint(thing.mesh, thing.T_world_thing).grown(BODY_M)
            cv2.fillConvexPoly(taken, np.round(area.corners() / CELL_M).astype(np.int32), 1)
    free: Bool = taken == 0
    return free


def _region_at_door(draft: Draft, region: np.ndarray) -> int:
    """Return the number of the connected region in front of the door, -1 when it is blocked."""
    door = next(thing for thing in draft.things if thing.label == DOOR.label)
    way = front_area(door.mesh, door.T_world_thing, DOORWAY_M)
    x, y = way.at(0.0, -way.half_depth * 0.3)
    row, column = int(y / CELL_M), int(x / CELL_M)
    near = region[max(row - 4, 0) : row + 5, max(column - 4, 0) : column + 5]
    regions = near[near > 0]
    return int(regions[0]) if regions.size else -1
