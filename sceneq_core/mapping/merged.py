"""Several changes of the map told as one: for readers that look now and then, over a thin link."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sceneq_core.arrays import Array, Bool, Int32
from sceneq_core.mapping.delta import Instance, MapDelta


def merged(deltas: Sequence[MapDelta]) -> MapDelta:
    """Return one delta that makes of a replica what ``deltas``, in their order, make of it.

    Of a voxel or instance that changed several times only its last state is told: ten keyframes of
    one room make little more than one. What came before a delta with ``full`` does not matter.

    Raises:
        ValueError: there are none.
    """
    if not deltas:
        raise ValueError("merged: no deltas")
    begin = max((i for i, delta in enumerate(deltas) if delta.full), default=0)
    told = deltas[begin:]
    if len(told) == 1:
        return told[0]
    voxel_id, rows = _last_rows([delta.voxel_id for delta in told])
    return replace(
        told[-1],
        full=told[0].full,
        voxel_id=voxel_id,
        voxel_coord=_column(told, "voxel_coord")[rows],
        points_world=_column(told, "points_world")[rows],
        rgb=_column(told, "rgb")[rows],
        superpoint_id=_column(told, "superpoint_id")[rows],
        removed_voxel_id=_still_removed(told),
        instances=_last_instances(told),
        events=tuple(event for delta in told for event in delta.events),
        moved_from_id=_column(told, "moved_from_id"),
        moved_to_id=_column(told, "moved_to_id"),
    )


def _column(deltas: Sequence[MapDelta], name: str) -> Array:
    return np.concatenate([getattr(delta, name) for delta in deltas])


def _last_rows(ids: Sequence[Int32]) -> tuple[Int32, Int32]:
    """Return the distinct ids, sorted, and where among all rows each stands last."""
    every = np.concatenate(ids)
    distinct, from_the_end = np.unique(every[::-1], return_index=True)
    return distinct, (len(every) - 1 - from_the_end).astype(np.int32)


def _still_removed(deltas: Sequence[MapDelta]) -> Int32:
    """Return the voxels whose last mention, at which they are written before removed, removes."""
    mentions = [ids for delta in deltas for ids in (delta.voxel_id, delta.removed_voxel_id)]
    removes: Bool = np.repeat(np.tile([False, True], len(deltas)), [len(ids) for ids in mentions])
    distinct, rows = _last_rows(mentions)
    return distinct[removes[rows]]


def _last_instances(deltas: Sequence[MapDelta]) -> tuple[Instance, ...]:
    """Return the last state of each instance, in the order in which they were told."""
    last: dict[int, Instance] = {}
    for delta in deltas:
        for instance in delta.instances:
            last.pop(instance.instance_id, None)
            last[instance.instance_id] = instance
    return tuple(last.values())
