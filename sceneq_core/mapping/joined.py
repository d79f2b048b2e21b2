"""Several deltas in a row as one."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sceneq_core.mapping.delta import Instance, MapDelta


def joined(deltas: Sequence[MapDelta]) -> MapDelta:
    """Return the delta with the effect of ``deltas``, oldest first; none of them is ``full``."""
    newest = deltas[-1]
    if len(deltas) == 1:
        return newest
    written_id = np.concatenate([delta.voxel_id for delta in deltas])
    voxel_id, first = np.unique(written_id[::-1], return_index=True)
    row = len(written_id) - 1 - first  # of several rows about one voxel the newest
    instances: dict[int, Instance] = {}
    removed_id = newest.removed_voxel_id[:0]
    for delta in deltas:
        instances |= {instance.instance_id: instance for instance in delta.instances}
        removed_id = np.setdiff1d(removed_id, delta.voxel_id)
        removed_id = np.union1d(removed_id, delta.removed_voxel_id)
    return replace(
        newest,
        voxel_id=voxel_id,
        voxel_coord=np.concatenate([d.voxel_coord for d in deltas])[row],
        points_world=np.concatenate([d.points_world for d in deltas])[row],
        rgb=np.concatenate([d.rgb for d in deltas])[row],
        superpoint_id=np.concatenate([d.superpoint_id for d in deltas])[row],
        removed_voxel_id=removed_id.astype(np.int32),
        instances=tuple(instances[i] for i in sorted(instances)),
        events=tuple(event for delta in deltas for event in delta.events),
    )
