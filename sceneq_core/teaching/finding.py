"""Which instance of a map is the thing that was taught?"""

import numpy as np

from sceneq_core.mapping.delta import Instance
from sceneq_core.routing.scene import SceneSnapshot
from sceneq_core.teaching.album import Album
from sceneq_core.teaching.evidence import box_overlap
from sceneq_core.teaching.taught import Taught


def instance_in(snapshot: SceneSnapshot, instance_id: int) -> Instance | None:
    """Return an instance of the map, also one that cannot be answered with yet."""
    row = snapshot.find(instance_id)
    if row is not None:
        return snapshot.instances[row].geometry
    waiting = (one for one in snapshot.waiting if one.instance_id == instance_id)
    return next(waiting, None)


def find_again(taught: Taught, snapshot: SceneSnapshot, album: Album) -> tuple[Instance, float]:
    """Return the instance most probably that of what was taught, and the probability.

    Looks alone never do: it must overlap with where it was. There must be an instance at least.
    """
    columns = snapshot.columns
    overlap = box_overlap(taught.spot.aabb_world, columns.aabb_world)
    cosine = album.cosines(taught, columns.instance_id.astype(np.int64))
    p = np.where(overlap > 0, album.judgement.of_same(overlap, cosine), 0.0)
    best = int(np.argmax(p))
    return snapshot.instances[best].geometry, float(p[best])
