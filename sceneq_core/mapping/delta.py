"""How the map changed with one frame."""

from dataclasses import dataclass

from sceneq_core.arrays import Float32, Float64, Int32, UInt8


@dataclass(frozen=True, slots=True)
class Instance:
    """One object of the map; metres, world frame.

    ``state`` is ``active`` or ``removed``; ``merged_into`` and ``parent`` are instance ids or 0.
    ``superpoint_id`` int32 (S,) sorted; ``aabb_world`` (2, 3) minimum and maximum corner;
    ``T_world_box`` (4, 4) centre and axes of the oriented box, ``box_size_m`` (3,) its edges.
    """

    instance_id: int
    state: str
    merged_into: int
    parent: int
    superpoint_id: Int32
    voxel_count: int
    centre_world: Float64
    aabb_world: Float64
    T_world_box: Float64
    box_size_m: Float64
    first_seen_ns: int
    last_seen_ns: int


@dataclass(frozen=True, slots=True)
class MapDelta:
    """Changed voxels and instances after frame ``frame_seq``; the whole map when ``full``.

    Voxel arrays are parallel (M rows): ``voxel_id`` int32 dense from 0 and never reused,
    ``voxel_coord`` int32 (M, 3) = floor(p / voxel_size), ``points_world`` float32 (M, 3) mean
    position in metres, ``rgb`` uint8 (M, 3), ``superpoint_id`` int32, -1 = none.
    ``up_world`` float64 (3,) is the unit vector against gravity.
    """

    full: bool
    frame_seq: int
    stamp_ns: int
    voxel_size_m: float
    up_world: Float64
    voxel_id: Int32
    voxel_coord: Int32
    points_world: Float32
    rgb: UInt8
    superpoint_id: Int32
    removed_voxel_id: Int32
    instances: tuple[Instance, ...]
