"""A white box of 3 x 3 x 2.5 m with a window light, and cubes to put into it."""

import numpy as np

from sceneq_core.ingest.source import Camera
from sceneq_tools.room.category import Category
from sceneq_tools.room.light.quality import Quality
from sceneq_tools.room.mesh import Material, Mesh
from sceneq_tools.room.room import Light, Room, Thing

QUICK = Quality(shadow_rays=9, gather_rays=16, bounces=2, cell_m=0.1, threads=2)
SIZE_M = (3.0, 3.0, 2.5)
CAMERA = Camera(np.array([[100.0, 0, 79.5], [0, 100.0, 59.5], [0, 0, 1]]), (160, 120))
WHITE = Material((0.8, 0.8, 0.8))


def sheet(corner, edge_u, edge_v, material=WHITE) -> Mesh:
    """A rectangle that faces cross(edge_u, edge_v), texture once across it, v along edge_v."""
    corner, u, v = (np.array(part, np.float64) for part in (corner, edge_u, edge_v))
    normal = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
    return Mesh(
        np.array([corner, corner + u, corner + u + v, corner + v], np.float32),
        np.tile(normal, (4, 1)).astype(np.float32),
        np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32),
        np.array([[0, 1, 2], [0, 2, 3]], np.int32),
        np.zeros(2, np.int32),
        (material,),
    )


def joined(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    rows = np.cumsum([0, *(len(m.materials) for m in meshes)])
    return Mesh(
        np.concatenate([m.vertices for m in meshes]),
        np.concatenate([m.normals for m in meshes]),
        np.concatenate([m.uv for m in meshes]),
        np.concatenate([m.faces + s for m, s in zip(meshes, starts, strict=False)]).astype(
            np.int32
        ),
        np.concatenate([m.material_index + r for m, r in zip(meshes, rows, strict=False)]).astype(
            np.int32
        ),
        tuple(material for m in meshes for material in m.materials),
    )


def cube(side_m: float, material: Material = WHITE) -> Mesh:
    """A cube whose bottom centre is the origin."""
    h, s = side_m / 2, side_m
    return joined(
        sheet((-h, -h, 0), (0, s, 0), (s, 0, 0), material),
        sheet((-h, -h, s), (s, 0, 0), (0, s, 0), material),
        sheet((-h, -h, 0), (s, 0, 0), (0, 0, s), material),
        sheet((-h, h, 0), (0, 0, s), (s, 0, 0), material),
        sheet((-h, -h, 0), (0, 0, s), (0, s, 0), material),
        sheet((h, -h, 0), (0, s, 0), (0, 0, s), material),
    )


def thing(thing_id: int, mesh: Mesh, at=(0.0, 0.0, 0.0), is_stuff: bool = False) -> Thing:
    T_world_thing = np.eye(4)
    T_world_thing[:3, 3] = at
    category = Category(f"thing {thing_id}", "top", "", (), (), ("model",))
    return Thing(thing_id, category, "", mesh, T_world_thing, is_stuff=is_stuff)


def tiny_room(*things: Thing, radiance: float = 5.0) -> Room:
    """Floor 1, ceiling 2, walls 3 to 6, a light in the ceiling's middle, and ``things``."""
    w, d, h = SIZE_M
    shell = (
        sheet((0, 0, 0), (w, 0, 0), (0, d, 0)),
        sheet((0, 0, h), (0, d, 0), (w, 0, 0)),
        sheet((0, 0, 0), (0, 0, h), (w, 0, 0)),
        sheet((0, d, 0), (w, 0, 0), (0, 0, h)),
        sheet((0, 0, 0), (0, d, 0), (0, 0, h)),
        sheet((w, 0, 0), (0, 0, h), (0, d, 0)),
    )
    stuff = tuple(thing(k + 1, mesh, is_stuff=True) for k, mesh in enumerate(shell))
    light = Light(
        np.array([w / 2 - 0.25, d / 2 - 0.25, h - 0.01]),
        np.array([0, 0.5, 0.0]),
        np.array([0.5, 0, 0.0]),
        (radiance, radiance, radiance),
    )
    return Room("mixed", 7, SIZE_M, (*stuff, *things), (light,))


def looking(eye, target) -> np.ndarray:
    """T_world_camera, OpenCV axes, upright."""
    ahead = np.array(target, float) - eye
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, [0, 0, 1.0])
    right /= np.linalg.norm(right)
    T_world_camera = np.eye(4)
    T_world_camera[:3, :3] = np.stack([right, np.cross(ahead, right), ahead], axis=1)
    T_world_camera[:3, 3] = eye
    return T_world_camera
