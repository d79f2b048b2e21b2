"""A mapper that knows the answer: deltas of the ray-cast room with one superpoint per thing."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from sceneq_core.frame import Frame, depth_from_mm
from sceneq_core.mapping.delta import Instance, MapDelta
from sceneq_core.mapping.voxel_index import VoxelIndex

from support.room import Room

VOXEL_M = 0.03
NO_IDS = np.zeros(0, np.int32)


def frame_of(room: Room, i: int, n: int) -> tuple[Frame, np.ndarray]:
    """Return frame ``i`` of ``n`` and its instance image (H, W)."""
    rgb, depth_mm, things, T_world_camera = room.frame(i, n)
    frame = Frame(i, 1000 * i, rgb, depth_from_mm(depth_mm), room.K, T_world_camera)
    return frame, things


def instance(instance_id: int, superpoint_id: Iterable[int], **changes) -> Instance:
    """Return an active instance of the given superpoints at the origin."""
    plain = Instance(
        instance_id=instance_id,
        state="confirmed",
        merged_into=0,
        parent=0,
        superpoint_id=np.array(sorted(superpoint_id), np.int32),
        voxel_count=1,
        centre_world=np.zeros(3),
        aabb_world=np.zeros((2, 3)),
        T_world_box=np.eye(4),
        box_size_m=np.ones(3),
        first_seen_ns=0,
        last_seen_ns=0,
    )
    return replace(plain, **changes)


def delta(**changes) -> MapDelta:
    """Return a delta without voxels and instances, changed as told."""
    empty = MapDelta(
        full=False,
        frame_seq=0,
        stamp_ns=0,
        voxel_size_m=VOXEL_M,
        up_world=np.array([0.0, 0.0, 1.0]),
        voxel_id=NO_IDS,
        voxel_coord=np.zeros((0, 3), np.int32),
        points_world=np.zeros((0, 3), np.float32),
        rgb=np.zeros((0, 3), np.uint8),
        superpoint_id=NO_IDS,
        removed_voxel_id=NO_IDS,
        instances=(),
    )
    return replace(empty, **changes)


def voxels(voxel_id: Iterable[int], superpoint_id: Iterable[int]) -> dict[str, np.ndarray]:
    """Return the voxel columns of a delta: voxel ``i`` lies at (i, 0, 0)."""
    ids = np.array(list(voxel_id), np.int32)
    coord = np.zeros((len(ids), 3), np.int32)
    coord[:, 0] = ids
    return {
        "voxel_id": ids,
        "voxel_coord": coord,
        "points_world": (coord + 0.5).astype(np.float32) * VOXEL_M,
        "rgb": np.full((len(ids), 3), 90, np.uint8),
        "superpoint_id": np.array(list(superpoint_id), np.int32),
    }


@dataclass
class TrueMap:
    """Voxels of the room by id; the instance of thing ``k`` (from 1) is ``k``."""

    room: Room = field(default_factory=Room)
    index: VoxelIndex = field(default_factory=VoxelIndex)
    coord: dict[int, tuple[int, ...]] = field(default_factory=dict)
    thing: dict[int, int] = field(default_factory=dict)
    frame_seq: int = -1

    def integrate(self, frame: Frame, things: np.ndarray) -> MapDelta:
        """Add a frame with its instance image; return what changed."""
        coord, thing = self._measured(frame, things)
        ids = self.index.insert(coord)
        new = np.unique(ids, return_index=True)[1]
        new = [k for k in new if int(ids[k]) not in self.thing]
        for k in new:
            self.coord[int(ids[k])] = tuple(coord[k])
            self.thing[int(ids[k])] = int(thing[k])
        self.frame_seq = frame.seq
        return self._delta([int(ids[k]) for k in new], full=False)

    def snapshot(self) -> MapDelta:
        """Return the whole map."""
        return self._delta(sorted(self.thing), full=True)

    def _measured(self, frame: Frame, things: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        v, u = np.nonzero(frame.depth_m > 0)
        z = frame.depth_m[v, u].astype(np.float64)
        K, T_world_camera = frame.K, frame.T_world_camera
        points = np.stack([(u - K[0, 2]) / K[0, 0] * z, (v - K[1, 2]) / K[1, 1] * z, z], axis=1)
        world = points @ T_world_camera[:3, :3].T + T_world_camera[:3, 3]
        return np.floor(world / VOXEL_M).astype(np.int32), things[v, u]

    def _delta(self, ids: list[int], full: bool) -> MapDelta:
        coord = np.array([self.coord[i] for i in ids], np.int32).reshape(-1, 3)
        thing = np.array([self.thing[i] for i in ids], np.int32)
        return delta(
            full=full,
            frame_seq=self.frame_seq,
            stamp_ns=1000 * self.frame_seq,
            voxel_id=np.array(ids, np.int32),
            voxel_coord=coord,
            points_world=(coord + 0.5).astype(np.float32) * np.float32(VOXEL_M),
            rgb=np.full((len(ids), 3), 90, np.uint8),
            superpoint_id=thing,
            instances=tuple(
                instance(k, [k], centre_world=np.array(self.room.things[k - 1].centre))
                for k in sorted(set(thing.tolist()))
            ),
        )
