"""What a camera pose would show, in a thumbnail: enough to plan where to look."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from sceneq_core.arrays import Array, Float32, Float64, Int64
from sceneq_core.ingest.source import Camera
from sceneq_tools.room.room import Room, Thing

HANDHELD = Camera(
    np.array([[525.0, 0.0, 319.5], [0.0, 525.0, 239.5], [0.0, 0.0, 1.0]]), size=(640, 480)
)
"""The nominal camera of the first consumer depth sensors: 62.7 by 49.1 degrees."""
SHRINK = 8
"""One ray for so many pixels across: 80x60 for VGA."""


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """``pixels`` int64 (N,) of the full image per thing, in the order of ``Glance.ids``."""

    pixels: Int64
    middle_m: float
    """Median depth of the image."""


class Glance:
    """Casts few rays into a room.

    Attributes:
        ids: int64 (N,), the ids of the room's things in their order.
    """

    def __init__(self, room: Room, camera: Camera = HANDHELD) -> None:
        """Take the room's geometry as it is now."""
        import open3d as o3d

        self.ids: Int64 = np.array([thing.id for thing in room.things], dtype=np.int64)
        self._rays = _rays(camera)
        self._scene = o3d.t.geometry.RaycastingScene()
        for thing in room.things:
            vertices = np.ascontiguousarray(corners_world(thing).reshape(-1, 3), np.float32)
            faces = np.arange(len(vertices), dtype=np.uint32).reshape(-1, 3)
            self._scene.add_triangles(_tensor(vertices), _tensor(faces))

    def at(self, T_world_camera: Float64) -> Seen:
        """Return what is seen from a pose (4, 4), OpenCV axes."""
        turned = self._rays @ T_world_camera[:3, :3].T
        origins = np.broadcast_to(T_world_camera[:3, 3], turned.shape)
        rays = np.concatenate([origins, turned], axis=1).astype(np.float32)
        hit = self._scene.cast_rays(_tensor(rays))
        depth_m: Float32 = hit["t_hit"].numpy()  # the rays have z = 1: this is z-depth
        index = hit["geometry_ids"].numpy()[np.isfinite(depth_m)]
        pixels = np.bincount(index, minlength=len(self.ids)) * SHRINK**2
        return Seen(pixels.astype(np.int64), float(np.median(depth_m)))


def corners_world(thing: Thing) -> Float64:
    """Return the corners of every triangle, (M, 3, 3) world metres."""
    to_world, place = thing.T_world_thing[:3, :3], thing.T_world_thing[:3, 3]
    vertices = thing.mesh.vertices.astype(np.float64) @ to_world.T + place
    return np.asarray(vertices[thing.mesh.faces])


def _rays(camera: Camera) -> Float64:
    width, height = camera.size
    u, v = np.meshgrid(np.arange(SHRINK / 2, width, SHRINK), np.arange(SHRINK / 2, height, SHRINK))
    pixels = np.stack([u.ravel(), v.ravel(), np.ones(u.size)], axis=1)
    return np.asarray(pixels @ np.linalg.inv(camera.K).T)


def _tensor(array: Array) -> Any:
    import open3d as o3d

    return o3d.core.Tensor.from_numpy(array)
