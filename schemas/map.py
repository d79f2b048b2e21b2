"""What mapping writes: how the instance map changed with one keyframe, or all of it."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from sceneq_schemas.arrays import Array, ArraySpec


@dataclass(frozen=True, slots=True)
class Instance:
    """One object of the map.

    ``state`` is ``active`` or ``removed``; ``merged_into`` and ``parent`` are instance ids or 0.
    Boxes are in metres in the world frame: ``aabb_world`` rows are minimum and maximum corner;
    the oriented box has centre and axes in ``T_world_box`` and edge lengths ``box_size_m``.
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


@dataclass(frozen=True, slots=True)
class MapDelta:
    """Everything that differs from the map of ``seq - 1`` in the same ``epoch``.

    A new epoch starts with every start of the writer. With ``full`` the message holds the whole
    map as of ``seq``. Voxel arrays are parallel; a voxel keeps its id for the life of the epoch;
    ``superpoint_id`` -1 = none.
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
