"""A camera that walks through the furnished room and back, and an odometry that drifts."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from sceneq_core.ingest.shading import Shading, shading
from sceneq_core.ingest.source import Camera
from sceneq_core.ingest.transforms import inverse, rotation_of

from support.room import Float, Room

ROOM = Room(size=(160, 120), focal_px=130.0)
CAMERA = Camera(ROOM.K, ROOM.size)


@dataclass(frozen=True)
class Look:
    """One image of the walk: what the camera measured, and where it truly was."""

    depth_mm: np.ndarray
    shading: Shading
    T_world_camera: Float


def look(view: int, views: int) -> Look:
    """Return view ``view`` of ``views`` along the arc of the room."""
    rgb, depth_mm, _, T_world_camera = ROOM.frame(view, views)
    return Look(depth_mm, shading(rgb, CAMERA, np.eye(4)), T_world_camera)


def there_and_back(views: int) -> list[Look]:
    """Return the arc forth and back again: the last image shows what the first one showed."""
    forth = [look(i, views) for i in range(views)]
    return forth + forth[-2::-1]


def drifting(looks: list[Look], turn_rad: Float, shift_m: Float) -> list[Float]:
    """Return the poses that an odometry finds which errs alike at every step; the first is I."""
    error = np.eye(4)
    error[:3, :3], error[:3, 3] = rotation_of(turn_rad), shift_m
    poses = [np.eye(4)]
    for one, other in pairwise(looks):
        poses.append(poses[-1] @ inverse(one.T_world_camera) @ other.T_world_camera @ error)
    return poses


def from_first(looks: list[Look]) -> list[Float]:
    """Return the true poses in the coordinates of the first one."""
    T_first_world = inverse(looks[0].T_world_camera)
    return [T_first_world @ look.T_world_camera for look in looks]
