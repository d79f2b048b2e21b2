"""Small synthetic inputs of the map: walls of points, flat frames, views of the furnished room."""

import numpy as np

from sceneq_core.frame import Frame, depth_from_mm
from sceneq_core.mapping.mapper import MapperParams
from sceneq_core.mapping.surface import SurfaceParams, SurfacePoints

from support.room import Room

K = np.array([[100.0, 0, 39.5], [0, 100.0, 29.5], [0, 0, 1]])
SMALL = MapperParams(surface=SurfaceParams(stride_px=1))


def surface(points, rgb=(100, 100, 100), normal=(0, 0, -1), weight=1.0):
    """Return a surface of the given world points."""
    points = np.asarray(points, np.float64).reshape(-1, 3)
    count = len(points)
    return SurfacePoints(
        points_world=points,
        normals_world=np.broadcast_to(np.asarray(normal, np.float64), (count, 3)).copy(),
        rgb=np.broadcast_to(np.asarray(rgb, np.uint8), (count, 3)).copy(),
        weight=np.full(count, weight),
        row=np.zeros(count, np.int32),
        column=np.zeros(count, np.int32),
    )


def patch(x_m, y_m, z_m, step_m=0.01):
    """Return the points of an axis-aligned sheet at depth ``z_m``; x and y are (low, high)."""
    x, y = np.meshgrid(np.arange(*x_m, step_m), np.arange(*y_m, step_m))
    return np.stack((x.ravel(), y.ravel(), np.full(x.size, z_m)), axis=1) + step_m / 2


def flat_frame(depth_m, seq=0, rgb=(100, 100, 100), T_world_camera=None):
    """Return an 80 x 60 frame whose depth is a number or an array."""
    depth = np.broadcast_to(np.asarray(depth_m, np.float32), (60, 80)).copy()
    colour = np.broadcast_to(np.asarray(rgb, np.uint8), (60, 80, 3)).copy()
    pose = np.eye(4) if T_world_camera is None else T_world_camera
    return Frame(seq, seq * 100_000_000, colour, depth, K, pose)


def room_frames(count, room=None):
    """Return (frame, true instance image) pairs of an arc through the furnished room."""
    room = room or Room()
    views = []
    for i in range(count):
        rgb, depth_mm, instance, pose = room.frame(i, count)
        frame = Frame(i, i * 100_000_000, rgb, depth_from_mm(depth_mm), room.K, pose)
        views.append((frame, instance))
    return views
