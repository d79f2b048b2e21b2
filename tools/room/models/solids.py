"""Boxes, lathes, tubes and sheets: the parts that simple models are put together from.

Every part is a function that returns a ``Solid``; ``assembled`` makes one mesh of many. Texture
coordinates are in metres, so that one repetition of a texture is one metre; ``tiled`` changes that.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from sceneq_core.arrays import Float64, Int64
from sceneq_tools.room.mesh import Material, Mesh
from sceneq_tools.room.models.normals import unit_vectors

Point = tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A part: ``vertices``, ``normals`` (N, 3), ``uv`` (N, 2), ``faces`` (M, 3), one material."""

    vertices: Float64
    normals: Float64
    uv: Float64
    faces: Int64
    material: Material

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> "Solid":
        """Shift by metres."""
        return replace(self, vertices=self.vertices + np.array([x, y, z]))

    def turned(self, axis: str, degrees: float) -> "Solid":
        """Turn about a coordinate axis through the origin, right-handed."""
        turn = _rotation(axis, degrees).T
        return replace(self, vertices=self.vertices @ turn, normals=self.normals @ turn)

    def tiled(self, u: float, v: float) -> "Solid":
        """Repeat the texture ``u`` and ``v`` times as often."""
        return replace(self, uv=self.uv * np.array([u, v]))


def assembled(parts: Sequence[Solid]) -> Mesh:
    """Make one mesh of parts; parts that share a material object share its slot."""
    materials: list[Material] = []
    slots = []
    for part in parts:
        if not any(part.material is material for material in materials):
            materials.append(part.material)
        slots.append(next(i for i, m in enumerate(materials) if m is part.material))
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    faces = [part.faces + start for part, start in zip(parts, starts, strict=False)]
    return Mesh(
        vertices=np.concatenate([part.vertices for part in parts]).astype(np.float32),
        normals=np.concatenate([part.normals for part in parts]).astype(np.float32),
        uv=np.concatenate([part.uv for part in parts]).astype(np.float32),
        faces=np.concatenate(faces).astype(np.int32),
        material_index=np.repeat(slots, [len(part.faces) for part in parts]).astype(np.int32),
        materials=tuple(materials),
    )


def box(material: Material, size: Point, centre: Point) -> Solid:
    """A block with sharp edges; ``size`` and ``centre`` in metres."""
    half = np.array(size) / 2
    sides = [_side(half, axis, sign) for axis in range(3) for sign in (-1.0, 1.0)]
    vertices, normals, uv = (np.concatenate(columns) for columns in zip(*sides, strict=True))
    faces = np.concatenate([np.array([[0, 1, 2], [0, 2, 3]]) + 4 * i for i in range(6)])
    return Solid(vertices + np.array(centre), normals, uv, faces, material)


def standing_box(material: Material, size: Point, at: Point) -> Solid:
    """A block by the centre of its underside."""
    return box(material, size, (at[0], at[1], at[2] + size[2] / 2))


def _side(half: Float64, axis: int, sign: float) -> tuple[Float64, Float64, Float64]:
    """One face of a box, seen from outside running left; upright faces have v up."""
    normal = np.zeros(3)
    normal[axis] = sign
    up = np.array([0.0, 1.0, 0.0]) if axis == 2 else np.array([0.0, 0.0, 1.0])
    right = np.cross(up, normal)
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    vertices = np.array([(normal + a * right + b * up) * half for a, b in corners])
    wide, high = 2 * np.abs(right) @ half, 2 * np.abs(up) @ half
    uv = np.array([((a + 1) / 2 * wide, (b + 1) / 2 * high) for a, b in corners])
    return vertices, np.tile(normal, (4, 1)), uv


def picture(material: Material, width: float, height: float, centre: Point) -> Solid:
    """An upright sheet that faces -y and shows its texture once."""
    x, y, z = centre
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    vertices = np.array([(x + a * width / 2, y, z + b * height / 2) for a, b in corners])
    uv = np.array([((a + 1) / 2, (b + 1) / 2) for a, b in corners])
    normals = np.tile([0.0, -1.0, 0.0], (4, 1))
    return Solid(vertices, normals, uv, np.array([[0, 1, 2], [0, 2, 3]]), material)


def lathe(
    material: Material,
    profile: Sequence[tuple[float, float]],
    steps: int = 32,
    crease_deg: float = 40.0,
) -> Solid:
    """Turn a profile of (radius, height) points about the z axis.

    Run the profile so that the outside is on its right hand: up for an outer wall, outwards for an
    underside. Bends sharper than ``crease_deg`` stay sharp.
    """
    rings = _rings(np.array(profile, dtype=np.float64), crease_deg)
    angle = np.linspace(0.0, 2 * np.pi, steps + 1)
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    sheets = [_sheet(around, start, end, n0, n1) for start, end, n0, n1 in rings]
    count = 2 * (steps + 1)
    vertices, normals, uv = (np.concatenate(columns) for columns in zip(*sheets, strict=True))
    faces = np.concatenate([_strip(steps) + count * i for i in range(len(sheets))])
    return Solid(vertices, normals, uv, faces, material)


def cylinder(material: Material, radius: float, height: float, at: Point, steps: int = 24) -> Solid:
    """An upright cylinder by the centre of its underside."""
    profile = [(0.0, 0.0), (radius, 0.0), (radius, height), (0.0, height)]
    return lathe(material, profile, steps).moved(*at)


def ball(material: Material, radius: float, centre: Point, steps: int = 24) -> Solid:
    """A sphere."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, steps // 2 + 1)
    profile = [(radius * float(np.cos(a)), radius * float(np.sin(a))) for a in angle]
    profile[0], profile[-1] = (0.0, -radius), (0.0, radius)
    return lathe(material, profile, steps).moved(*centre)


def tube(material: Material, path: npt.ArrayLike, radius: float, steps: int = 10) -> Solid:
    """A round bar along a path of (n, 3) points; ends open, bends smooth."""
    points = np.asarray(path, dtype=np.float64)
    ahead = unit_vectors(np.gradient(points, axis=0))
    side = unit_vectors(np.cross(ahead, _away_from(ahead)))
    across = np.cross(ahead, side)
    angle = np.linspace(0.0, 2 * np.pi, steps + 1)
    normals = np.cos(angle)[:, None] * side[:, None] + np.sin(angle)[:, None] * across[:, None]
    vertices = points[:, None] + radius * normals
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    uv = np.stack(np.broadcast_arrays(angle * radius, along[:, None]), axis=2)
    ring = steps + 1
    faces = np.concatenate([_strip(steps) + ring * i for i in range(len(points) - 1)])
    return Solid(
        vertices.reshape(-1, 3), normals.reshape(-1, 3), uv.reshape(-1, 2), faces, material
    )


def _strip(steps: int) -> Int64:
    """Two rings of ``steps + 1`` vertices each, joined by triangles."""
    i, ring = np.arange(steps), steps + 1
    lower = np.stack([i, i + 1, i + 1 + ring], axis=1)
    upper = np.stack([i, i + 1 + ring, i + ring], axis=1)
    return np.concatenate([lower, upper])


def _away_from(directions: Float64) -> Float64:
    """One axis that none of the directions runs along."""
    axis = int(np.argmin(np.abs(directions).max(axis=0)))
    return np.asarray(np.eye(3)[axis])


def _rings(profile: Float64, crease_deg: float) -> list[tuple[Float64, Float64, Float64, Float64]]:
    """Start, end and the normals there (radial, height) of each piece of a profile."""
    step = np.diff(profile, axis=0)
    flat = unit_vectors(np.stack([step[:, 1], -step[:, 0]], axis=1))
    limit = np.cos(np.deg2rad(crease_deg))
    rings = []
    for i, normal in enumerate(flat):
        before = flat[i - 1] if i > 0 and normal @ flat[i - 1] >= limit else normal
        after = flat[i + 1] if i + 1 < len(flat) and normal @ flat[i + 1] >= limit else normal
        rings.append((profile[i], profile[i + 1], normal + before, normal + after))
    return rings


def _sheet(
    around: Float64, start: Float64, end: Float64, normal_start: Float64, normal_end: Float64
) -> tuple[Float64, Float64, Float64]:
    """One ring of a lathe: vertices, normals and uv of its lower and upper circle."""
    radius = max(float(start[0]), float(end[0]))
    u = np.linspace(0.0, 2 * np.pi * radius, len(around))
    vertices, normals, uv = [], [], []
    for point, normal, v in ((start, normal_start, 0.0), (end, normal_end, 1.0)):
        vertices.append(np.column_stack([around * point[0], np.full(len(around), point[1])]))
        normals.append(np.column_stack([around * normal[0], np.full(len(around), normal[1])]))
        uv.append(np.column_stack([u, np.full(len(around), v * np.linalg.norm(end - start))]))
    return np.concatenate(vertices), unit_vectors(np.concatenate(normals)), np.concatenate(uv)


def _rotation(axis: str, degrees: float) -> Float64:
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    i = "xyz".index(axis)
    rotation = np.eye(3)
    j, k = (i + 1) % 3, (i + 2) % 3
    rotation[[j, j, k, k], [j, k, j, k]] = c, -s, s, c
    return rotation
