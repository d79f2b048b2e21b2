"""A small room as points: floor, two walls, a ceiling, three boxes; no recording needed."""

import numpy as np

from sceneq_core.picture.scene import Cloud, Mark, Thing

VOXEL_M = 0.03
FLOOR, WALL, CEILING = 1, 2, 3
BOXES = {10: (1.0, 1.0), 11: (3.0, 1.0), 12: (2.0, 2.2)}
BOX_M = 0.5
UP_Z = np.array([0.0, 0.0, 1.0])


def grid(low: "tuple[float, ...]", high: "tuple[float, ...]") -> np.ndarray:
    """Return points every ``VOXEL_M`` in a box that may be flat."""
    axes = [np.arange(a, max(b, a + 1e-6), VOXEL_M) for a, b in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def room_points() -> "tuple[np.ndarray, np.ndarray]":
    """Return points (N, 3), z up, and the instance of each."""
    parts = {
        FLOOR: [grid((0, 0, 0), (4, 3, 0))],
        WALL: [grid((0, 3, 0), (4, 3, 2.5)), grid((0, 0, 0), (0, 3, 2.5))],
        CEILING: [grid((0, 0, 2.5), (4, 3, 2.5))],
    }
    for number, (x, y) in BOXES.items():
        parts[number] = [grid((x, y, 0.02), (x + BOX_M, y + BOX_M, BOX_M))]
    points = [(np.concatenate(some), number) for number, some in parts.items()]
    ids = [np.full(len(some), number, np.int32) for some, number in points]
    return np.concatenate([some for some, _ in points]), np.concatenate(ids)


def cloud(R_world_room: "np.ndarray | None" = None) -> Cloud:
    """Return the room, turned by ``R_world_room``."""
    turn = np.eye(3) if R_world_room is None else R_world_room
    points, ids = room_points()
    rgb = np.full((len(points), 3), 160, np.uint8)
    return Cloud((points @ turn.T).astype(np.float32), rgb, ids, VOXEL_M, turn @ UP_Z)


def only(scene: Cloud, keep: np.ndarray) -> Cloud:
    """Return the points of ``scene`` that are to be kept (N,)."""
    points, rgb, ids = scene.points_world, scene.rgb, scene.instance_id
    return Cloud(points[keep], rgb[keep], ids[keep], VOXEL_M, scene.up_world)


def open_room() -> Cloud:
    """Return the room without its ceiling."""
    scene = cloud()
    return only(scene, scene.instance_id != CEILING)


def things() -> "list[Thing]":
    """Return the captions of the room."""
    shells = [Thing(n, str(n), 0.0, False, (4.0, 3.0, 0.1)) for n in (FLOOR, WALL, CEILING)]
    boxes = [Thing(n, f"{n} box", 0.4, True, (BOX_M, BOX_M, BOX_M)) for n in BOXES]
    return [*shells, *boxes]


def mark(number: int, R_world_room: "np.ndarray | None" = None) -> Mark:
    """Return a mark on one of the boxes."""
    turn = np.eye(3) if R_world_room is None else R_world_room
    x, y = BOXES[number]
    side = (np.arange(8)[:, None] >> np.arange(3)) & 1
    return Mark(number, f"{number} box", (np.array([x, y, 0.0]) + side * BOX_M) @ turn.T)
