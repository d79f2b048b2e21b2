"""How the map changed with one frame."""

from dataclasses import dataclass, field

import numpy as np

from sceneq_core.arrays import Float32, Float64, Int32, UInt8

TENTATIVE, CONFIRMED, STALE, REMOVED = "tentative", "confirmed", "stale", "removed"
STATES = (TENTATIVE, CONFIRMED, STALE, REMOVED)
"""``tentative``: seen too little to answer with; ``confirmed``; ``stale``: its place was looked
at and it was not found there, or only in part; ``removed``: gone, merged or never real."""

OBJECT, FLOOR, WALL, CEILING = "object", "floor", "wall", "ceiling"
ROLES = (OBJECT, FLOOR, WALL, CEILING)

MAX_INSTANCES = 1 << 24
"""Ids are below: readers keep tables by id, and a damaged one is not to eat their memory."""

EVENTS = ("appeared", "confirmed", "moved", "stale", "seen_again", "split", "merged", "removed")


def _no_ids() -> Int32:
    return np.zeros(0, np.int32)


@dataclass(frozen=True, slots=True)
class Place:
    """Where an instance was before it was found elsewhere; metres, world frame."""

    centre_world: Float64
    aabb_world: Float64
    from_ns: int
    until_ns: int


@dataclass(frozen=True, slots=True)
class Event:
    """A transition of ``instance_id``, one of ``EVENTS``.

    ``other_id`` is what it was merged into or split from, else 0.
    """

    kind: str
    instance_id: int
    other_id: int
    stamp_ns: int


@dataclass(frozen=True, slots=True)
class Instance:
    """One object of the map; metres, world frame.

    ``state`` is one of ``STATES``, since ``state_since_ns``; ``role`` one of ``ROLES``.
    ``merged_into`` and ``parent`` are instance ids or 0. ``superpoint_id`` int32 (S,) sorted;
    ``aabb_world`` (2, 3) minimum and maximum corner; ``T_world_box`` (4, 4) centre and axes of the
    oriented box, ``box_size_m`` (3,) its edges. ``places`` are the earlier ones, oldest first.
    ``supported_by`` is what it stands, lies or hangs on, ``inside`` what holds it, 0 = not known;
    ``neighbour_id`` int32 (N,) what is next to it, sorted.
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
    state_since_ns: int = 0
    role: str = OBJECT
    places: tuple[Place, ...] = ()
    supported_by: int = 0
    inside: int = 0
    neighbour_id: Int32 = field(default_factory=_no_ids)


@dataclass(frozen=True, slots=True)
class MapDelta:
    """Changed voxels and instances after frame ``frame_seq``; the whole map when ``full``.

    Voxel arrays are parallel (M rows): ``voxel_id`` int32 dense from 0 and never reused,
    ``voxel_coord`` int32 (M, 3) = floor(p / voxel_size), ``points_world`` float32 (M, 3) mean
    position in metres, ``rgb`` uint8 (M, 3), ``superpoint_id`` int32, -1 = none.
    ``up_world`` float64 (3,) is the unit vector against gravity. ``quarantined`` says why the frame
    was kept out of the map, empty when it was not. After a correction of poses the surface of
    voxels ``moved_from_id`` int32 (N,) is in ``moved_to_id`` (N,).
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
    events: tuple[Event, ...] = ()
    quarantined: str = ""
    moved_from_id: Int32 = field(default_factory=_no_ids)
    moved_to_id: Int32 = field(default_factory=_no_ids)
