"""What a scene takes of messages: numbers that JSON can say, and views that have a box."""

import numpy as np

from sceneq_core.mapping.delta import Instance
from sceneq_core.routing.scene import ViewRef
from sceneq_schemas.view import ViewDelta


def is_finite(instance: Instance) -> bool:
    """JSON has no NaN, and a box without place is no answer."""
    numbers = (instance.centre_world, instance.aabb_world, instance.T_world_box)
    return all(np.isfinite(n).all() for n in (*numbers, instance.box_size_m))


def view_refs(message: ViewDelta) -> dict[int, tuple[ViewRef, ...]]:
    """Return the views by instance id, without those whose box is not finite."""
    return {
        view_set.instance_id: tuple(
            ViewRef(view.seq, tuple(view.box_xyxy.tolist()))
            for view in view_set.views
            if np.isfinite(view.box_xyxy).all()
        )
        for view_set in message.view_sets
    }
