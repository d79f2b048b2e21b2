"""A room made for portraits: a few things in a row along a wall, under any light."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from sceneq_core.arrays import Array, Float64
from sceneq_tools.room.category import Category
from sceneq_tools.room.layout.placement import pose
from sceneq_tools.room.layout.sheets import sheet
from sceneq_tools.room.mesh import Material, Mesh
from sceneq_tools.room.models.solids import Solid, assembled, standing_box
from sceneq_tools.room.models.sweet_home import SweetHomeLibrary
from sceneq_tools.room.portrait.paint import floor_and_wall, furniture_top, repainted
from sceneq_tools.room.portrait.sitters import Sitter
from sceneq_tools.room.room import Light, Room, Thing

LARGEST_M = 5.0
"""What is larger is no furniture."""
SMALL_M = 0.6
"""What is smaller mostly stands on something."""
HANGS_M = 0.3
"""What the catalogue has higher above the floor hangs on the wall."""
FIRST_ID = 10
WARM, COLD = (1.0, 0.84, 0.66), (0.9, 0.95, 1.05)


@dataclass(frozen=True, slots=True, eq=False)
class Posed:
    """A sitter in its place: instance ``id``, ``centre`` (3,) and ``size`` (3,) in metres."""

    id: int
    sitter: Sitter
    centre: Float64
    size: Float64

    @property
    def underside_m(self) -> float:
        """How high above the floor it stands or hangs."""
        return float(self.centre[2] - self.size[2] / 2)


@dataclass(slots=True)
class _Row:
    """A row that grows along x; it ends at ``right`` so far."""

    depth: float
    height: float
    right: float = 0.6
    next_id: int = FIRST_ID
    things: list[Thing] = field(default_factory=list)
    posed: list[Posed] = field(default_factory=list)

    def add(self, name: str, model_id: str, mesh: Mesh, T_world: Float64) -> int:
        category = Category(name, "top", "", (), (), (model_id or name,))
        self.things.append(Thing(self.next_id, category, model_id, mesh, T_world))
        self.next_id += 1
        return self.next_id - 1


def stage(
    library: SweetHomeLibrary, chosen: Sequence[Sitter], number: int, rng: np.random.Generator
) -> tuple[Room, tuple[Posed, ...]]:
    """Return a room with the chosen sitters that fit into one, and where they are.

    Raises:
        ValueError: a model that cannot be read.
    """
    height, depth = rng.uniform(2.4, 3.0), rng.uniform(3.5, 6.0)
    row = _Row(depth, height)
    for sitter in chosen:
        mesh = repainted(library.mesh(sitter.model_id, sitter.scale), rng)
        if max(np.ptp(mesh.vertices, axis=0)) <= LARGEST_M:
            _seat(row, sitter, mesh, rng)
    width = row.right + 0.6
    size_m = (width, depth, height)
    things = (*_shell(size_m, rng), *row.things)
    lights = _lights(size_m, rng)
    return Room("mixed", number, size_m, things, lights), tuple(row.posed)


def _seat(row: _Row, sitter: Sitter, mesh: Mesh, rng: np.random.Generator) -> None:
    """Put a thing at the end of the row: on the floor, on something, or on the wall."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    size = high - low
    hangs = sitter.elevation_m > HANGS_M
    gap = rng.uniform(0.05, 0.7)
    x = row.right + (size[0] / 2 + gap)
    near_wall = hangs or rng.random() < 0.6
    behind = rng.uniform(0.0, 0.05) if near_wall else rng.uniform(0.1, 1.0)
    y, z = row.depth - behind - size[1] / 2 - 0.01, sitter.elevation_m
    if sitter.elevation_m == 0 and max(size) < SMALL_M and rng.random() < 0.8:
        y, z = _support(row, x, size, rng)
    if hangs:
        z = min(z, row.height - size[2] - 0.01)
    yaw = 0.0 if hangs or rng.random() < 0.5 else rng.uniform(-0.6, 0.6)
    T_world = pose(x, y, z - float(low[2]), yaw)
    middle = (low + high) / 2
    T_world[:3, 3] -= T_world[:3, :3] @ np.array([middle[0], middle[1], 0])
    thing_id = row.add(sitter.name, sitter.model_id, mesh, T_world)
    centre = np.array([x, y, z + size[2] / 2])
    row.posed.append(Posed(thing_id, sitter, centre, size.astype(np.float64)))
    row.right = x + (size[0] / 2 + gap)


def _support(row: _Row, x: float, size: Array, rng: np.random.Generator) -> tuple[float, float]:
    """Add a block for a small thing; return y and z of its top's middle."""
    z = rng.uniform(0.35, 0.95)
    top = (max(size[0] * 1.6, 0.5), max(size[1] * 1.6, 0.4), z)
    y = row.depth - max(size[1] * 0.8, 0.2) - 0.02
    block = standing_box(furniture_top(rng), top, (0, 0, 0))
    row.add("support", "", assembled([block]), pose(x, y))
    return y, z


def _shell(size_m: tuple[float, float, float], rng: np.random.Generator) -> tuple[Thing, ...]:
    """Return floor, ceiling and walls."""
    width, depth, height = size_m
    floor, wall = floor_and_wall(rng)
    white = Material(colour=(0.9, 0.9, 0.88))
    up = (0, 0, height)
    return (
        _stuff(1, "floor", sheet(floor, (0, 0, 0), (width, 0, 0), (0, depth, 0))),
        _stuff(2, "ceiling", sheet(white, (0, depth, height), (width, 0, 0), (0, -depth, 0))),
        _stuff(3, "wall", sheet(wall, (0, depth, 0), (width, 0, 0), up)),
        _stuff(4, "wall", sheet(wall, (width, 0, 0), (-width, 0, 0), up)),
        _stuff(5, "wall", sheet(wall, (0, 0, 0), (0, depth, 0), up)),
        _stuff(6, "wall", sheet(wall, (width, depth, 0), (0, -depth, 0), up)),
    )


def _stuff(number: int, name: str, part: Solid) -> Thing:
    category = Category(name, "top", "", (), (), (name,))
    return Thing(number, category, "", assembled([part]), np.eye(4), is_stuff=True)


def _lights(size_m: tuple[float, float, float], rng: np.random.Generator) -> tuple[Light, ...]:
    """Return one to three lamps in the ceiling."""
    return tuple(_lamp(size_m, rng) for _ in range(int(rng.integers(1, 4))))


def _lamp(size_m: tuple[float, float, float], rng: np.random.Generator) -> Light:
    width, depth, height = size_m
    tone = np.array(WARM if rng.random() < 0.5 else COLD)
    side = rng.uniform(0.3, 1.2)
    x, y = rng.uniform(0.2, max(0.3, width - 1.4)), rng.uniform(0.3, depth - 1.5)
    red, green, blue = (tone * rng.uniform(6, 16) / side / side).tolist()
    corner = np.array([x, y, height - 0.02])
    return Light(corner, np.array([0, side, 0.0]), np.array([side, 0, 0.0]), (red, green, blue))
