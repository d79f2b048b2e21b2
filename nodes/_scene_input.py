"""What a scene takes of messages: ids and numbers that a map can have, views that have a box."""

import numpy as np

from sceneq_core.mapping.delta import MAX_INSTANCES, Instance
from sceneq_core.routing.scene import ViewRef
from sceneq_schemas.view import ViewDelta

FARTHEST_M = 1e6
"""What is farther away than that is no place in a map."""


def is_usable(instance: Instance) -> bool:
    """Tell whether it has an id and a place: JSON has no NaN, and no box is no answer."""
    numbers = (instance.centre_world, instance.aabb_world, instance.T_world_box)
    near = all((np.abs(n) <= FARTHEST_M).all() for n in (*numbers, instance.box_size_m))
    return near and is_id(instance.instance_id)


def is_id(instance_id: int) -> bool:
    """Tell whether a map gives such ids."""
    return 0 < instance_id < MAX_INSTANCES


def view_refs(message: ViewDelta) -> dict[int, tuple[ViewRef, ...]]:
    """Return the views by instance id, without those that have no box."""
    return {
        view_set.instance_id: tuple(
            ViewRef(view.seq, tuple(view.box_xyxy.tolist()))
            for view in view_set.views
            if np.isfinite(view.box_xyxy).all()
        )
        for view_set in message.view_sets
        if is_id(view_set.instance_id)
    }
