"""What mapping writes: how the instance map changed with one keyframe, or all of it."""

from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import numpy as np

from sceneq_schemas.arrays import Array, ArraySpec


def _no_ids() -> Array:
    return np.zeros(0, np.int32)


@dataclass(frozen=True, slots=True)
class Place:
    """Where an instance was before it was found elsewhere; metres, world frame."""

    centre_world: Annotated[Array, ArraySpec("<f8", (3,))]
    aabb_world: Annotated[Array, ArraySpec("<f8", (2, 3))]
    from_ns: int
    until_ns: int


@dataclass(frozen=True, slots=True)
class Event:
    """A transition of an instance at ``stamp_ns``.

    ``kind`` is ``appeared``, ``confirmed``, ``moved``, ``stale``, ``seen_again``, ``split``,
    ``merged`` or ``removed``; ``other_id`` is what it was merged into or split from, else 0.
    """

    kind: str
    instance_id: int
    other_id: int
    stamp_ns: int


@dataclass(frozen=True, slots=True)
class Instance:
    """One object of the map.

    ``state`` is ``tentative``, ``confirmed``, ``stale`` or ``removed``, since ``state_since_ns``;
    ``role`` is ``object``, ``floor``, ``wall`` or ``ceiling``. ``merged_into``, ``parent``,
    ``supported_by`` and ``inside`` are instance ids or 0. Boxes are in metres in the world frame:
    ``aabb_world`` rows are minimum and maximum corner; the oriented box has centre and axes in
    ``T_world_box`` and edge lengths ``box_size_m``. ``places`` are the earlier ones, oldest first.
    """

    instance_id: int
    state: str
    merged_into: int
    parent: int
    superpoint_id: Annotated[Array, ArraySpec("<i4", (None,))]
    voxel_count: int
    centre_world: Annotated[Array, ArraySpec("<f8", (3,))]
    aabb_world: Annotated[Array, ArraySpec("<f8", (2, 3))]
    T_world_box: Annotated[Array, ArraySpec("<f8", (4, 4))]
    box_size_m: Annotated[Array, ArraySpec("<f8", (3,))]
    first_seen_ns: int
    last_seen_ns: int
    state_since_ns: int = 0
    role: str = "object"
    places: tuple[Place, ...] = ()
    supported_by: int = 0
    inside: int = 0
    neighbour_id: Annotated[Array, ArraySpec("<i4", (None,))] = field(default_factory=_no_ids)


@dataclass(frozen=True, slots=True)
class MapDelta:
    """Everything that differs from the map of ``seq - 1`` in the same ``epoch``.

    A new epoch starts with every start of the writer. With ``full`` the message holds the whole
    map as of ``seq``. Voxel arrays are parallel; a voxel keeps its id for the life of the epoch;
    ``superpoint_id`` -1 = none. ``quarantined`` says why frame ``frame_seq`` was kept out of the
    map, empty when it was not. After a correction of poses the surface of voxels
    ``moved_from_id`` is in ``moved_to_id``, row by row.
    """

    VERSION: ClassVar[int] = 1
    SCHEMA: ClassVar[str] = "sceneq.map.v1"
    epoch: int
    seq: int
    full: bool
    frame_seq: int
    stamp_ns: int
    voxel_size_m: float
    up_world: Annotated[Array, ArraySpec("<f8", (3,))]
    voxel_id: Annotated[Array, ArraySpec("<i4", (None,))]
    voxel_coord: Annotated[Array, ArraySpec("<i4", (None, 3))]
    points_world: Annotated[Array, ArraySpec("<f4", (None, 3))]
    rgb: Annotated[Array, ArraySpec("|u1", (None, 3))]
    superpoint_id: Annotated[Array, ArraySpec("<i4", (None,))]
    removed_voxel_id: Annotated[Array, ArraySpec("<i4", (None,))]
    instances: tuple[Instance, ...]
    events: tuple[Event, ...] = ()
    quarantined: str = ""
    moved_from_id: Annotated[Array, ArraySpec("<i4", (None,))] = field(default_factory=_no_ids)
    moved_to_id: Annotated[Array, ArraySpec("<i4", (None,))] = field(default_factory=_no_ids)


@dataclass(frozen=True, slots=True)
class MapDeltas:
    """The deltas of ``epoch`` that somebody missed, in order; with them the map is that of ``seq``.

    Their numbers may leave some out: those told nothing.
    """

    VERSION: ClassVar[int] = 1
    SCHEMA: ClassVar[str] = "sceneq.map_journal.v1"
    epoch: int
    seq: int
    deltas: tuple[MapDelta, ...]
