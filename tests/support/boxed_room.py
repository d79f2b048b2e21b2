"""A furnished room of plain boxes: enough to walk in, to look at and to change."""

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_tools.room.category import Category
from sceneq_tools.room.mesh import Colour, Material, Mesh
from sceneq_tools.room.room import FLOOR_ID, Light, Room, Thing

WHITE: Colour = (0.9, 0.9, 0.9)
RED: Colour = (0.8, 0.1, 0.1)
BLUE: Colour = (0.1, 0.1, 0.8)


def box(size_m: tuple[float, float, float], colour: Colour = WHITE) -> Mesh:
    """A box standing on the origin, every face with its own corners."""
    half = np.array([size_m[0] / 2, size_m[1] / 2, size_m[2] / 2])
    vertices, normals, faces = [], [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            normal = np.zeros(3)
            normal[axis] = sign
            u = np.roll(normal, 1) * sign
            v = np.cross(normal, u)
            corners = [normal - u - v, normal + u - v, normal + u + v, normal - u + v]
            first = len(vertices)
            vertices += [corner * half + [0, 0, half[2]] for corner in corners]
            normals += [normal] * 4
            faces += [[first, first + 1, first + 2], [first, first + 2, first + 3]]
    return Mesh(
        vertices=np.array(vertices, np.float32),
        normals=np.array(normals, np.float32),
        uv=np.zeros((len(vertices), 2), np.float32),
        faces=np.array(faces, np.int32),
        material_index=np.zeros(len(faces), np.int32),
        materials=(Material(colour),),
    )


def placed(x: float, y: float, z: float = 0.0, yaw: float = 0.0) -> Float64:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, z], [0, 0, 0, 1]])


def category(label: str, role: str) -> Category:
    return Category(label, role, "wood", (), (), ("box",))


def thing(
    id: int,
    label: str,
    role: str,
    size_m: tuple[float, float, float],
    T_world_thing: Float64,
    support: int | None = FLOOR_ID,
    colour: Colour = WHITE,
    is_stuff: bool = False,
) -> Thing:
    mesh = box(size_m, colour)
    kind = category(label, role)
    return Thing(id, kind, "box", mesh, T_world_thing, support, is_stuff=is_stuff)


def boxed_room(width: float = 5.0, depth: float = 4.0, height: float = 2.6) -> Room:
    """A sofa, a desk with a mug and a book, a table in the middle, a wardrobe, a rug, a picture."""
    middle = (width / 2, depth / 2)
    things = (
        *_shell(width, depth, height),
        thing(6, "sofa", "sofa", (1.8, 0.8, 0.8), placed(1.4, depth - 0.45), colour=RED),
        thing(7, "desk", "desk", (1.4, 0.7, 0.74), placed(width - 0.4, 1.2, yaw=np.pi / 2)),
        thing(8, "mug", "top", (0.09, 0.09, 0.1), placed(width - 0.5, 1.1, 0.74), 7, RED),
        thing(9, "book", "top", (0.2, 0.14, 0.05), placed(width - 0.4, 1.5, 0.74), 7, BLUE),
        thing(10, "coffee table", "coffee_table", (0.9, 0.5, 0.42), placed(*middle)),
        thing(11, "wardrobe", "wardrobe", (1.0, 0.6, 2.0), placed(0.6, 0.35)),
        thing(12, "rug", "rug", (2.0, 1.4, 0.02), placed(*middle)),
        thing(13, "picture", "wall", (0.6, 0.03, 0.4), placed(3.2, depth - 0.02, 1.4), 3),
    )  # fmt: skip
    lamp = Light(
        corner=np.array([middle[0] - 0.5, middle[1] - 0.5, height - 0.01]),
        edge_u=np.array([0.0, 1.0, 0.0]),
        edge_v=np.array([1.0, 0.0, 0.0]),
        radiance=(8.0, 8.0, 8.0),
    )
    return Room("office", 0, (width, depth, height), things, (lamp,))


def _shell(width: float, depth: float, height: float) -> tuple[Thing, ...]:
    x, y = width / 2, depth / 2
    slabs = (
        ("floor", (width, depth, 0.1), placed(x, y, -0.1)),
        ("wall", (width, 0.1, height), placed(x, -0.05)),
        ("wall", (width, 0.1, height), placed(x, depth + 0.05)),
        ("wall", (0.1, depth, height), placed(-0.05, y)),
        ("wall", (0.1, depth, height), placed(width + 0.05, y)),
    )
    return tuple(
        thing(FLOOR_ID + k, label, "", size_m, T_world_thing, None, is_stuff=True)
        for k, (label, size_m, T_world_thing) in enumerate(slabs)
    )
