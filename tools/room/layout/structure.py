"""Floor, ceiling and walls."""

from dataclasses import dataclass

import numpy as np

from sceneq_tools.room.category import Category
from sceneq_tools.room.layout.draft import Draft
from sceneq_tools.room.layout.fittings import CEILING, FLOOR, WALL
from sceneq_tools.room.layout.placement import pose
from sceneq_tools.room.layout.sheets import sheet
from sceneq_tools.room.layout.stock import Item
from sceneq_tools.room.layout.wall import Wall
from sceneq_tools.room.mesh import Colour, Material, Mesh
from sceneq_tools.room.models.solids import Solid, assembled, box
from sceneq_tools.room.textures import textures

SKIRTING_M = (0.012, 0.08)
"""Thickness and height of the boards along the foot of the walls."""

SPLASHBACK_M = (0.85, 1.45)
"""Between worktop and upper cabinets a kitchen wall is tiled."""

PAINTS: tuple[Colour, ...] = (
    (0.86, 0.83, 0.76),
    (0.78, 0.82, 0.81),
    (0.84, 0.78, 0.70),
    (0.79, 0.82, 0.74),
    (0.87, 0.86, 0.84),
    (0.76, 0.80, 0.86),
    (0.86, 0.78, 0.75),
    (0.80, 0.77, 0.82),
)
WOODS: tuple[Colour, ...] = (
    (0.62, 0.45, 0.30),
    (0.48, 0.32, 0.21),
    (0.72, 0.58, 0.42),
    (0.40, 0.29, 0.22),
    (0.66, 0.61, 0.54),
)
STONES: tuple[Colour, ...] = (
    (0.80, 0.79, 0.76),
    (0.62, 0.60, 0.56),
    (0.74, 0.62, 0.52),
    (0.45, 0.46, 0.48),
)
PILES: tuple[Colour, ...] = ((0.60, 0.58, 0.54), (0.45, 0.50, 0.56), (0.62, 0.54, 0.46))


@dataclass(frozen=True, slots=True)
class Hole:
    """A rectangle cut out of a wall: left, right along it, bottom and top, metres."""

    left: float
    right: float
    bottom: float
    top: float


def build_structure(draft: Draft, floors: tuple[str, ...], holes: dict[int, list[Hole]]) -> None:
    """Add floor, ceiling and the four walls, which get the first six ids.

    Args:
        draft: an empty draft.
        floors: kinds of floor to choose from: ``planks``, ``tiles``, ``carpet``.
        holes: what is cut out of the walls, by side.
    """
    width, depth, height = draft.size_m
    rng = draft.rng
    floor_kind = str(rng.choice(floors))
    _stuff(draft, FLOOR, assembled([_floor(rng, floor_kind, width, depth)]))
    white = Material(texture=textures.plaster(rng, (0.92, 0.92, 0.90)), colour=(1, 1, 1))
    _stuff(
        draft, CEILING, assembled([sheet(white, (0, depth, height), (width, 0, 0), (0, -depth, 0))])
    )
    paint = _choice(rng, PAINTS)
    plain = Material(texture=textures.plaster(rng, paint), colour=(1, 1, 1))
    accent = Material(texture=_wallpaper(rng), colour=(1, 1, 1))
    papered = int(rng.integers(6))
    for wall in draft.walls:
        cover = accent if wall.side == papered else plain
        mesh = _wall(wall, height, cover, holes.get(wall.side, []))
        _stuff(draft, WALL, mesh, wall)


def tile_splashback(draft: Draft, wall: Wall, left: float, right: float) -> None:
    """Tile a wall behind a kitchen row, from ``left`` to ``right`` metres along it."""
    pattern = textures.tiles(draft.rng, _choice(draft.rng, STONES[:3]), count=8)
    tiled = Material(texture=pattern, colour=(1, 1, 1), shine=0.15, gloss=40)
    low, high = SPLASHBACK_M
    corner = (left, -0.003, low)
    face = sheet(tiled, corner, (right - left, 0, 0), (0, 0, high - low))
    _stuff(draft, WALL, assembled([face]), wall)


def _stuff(draft: Draft, category: Category, mesh: Mesh, wall: Wall | None = None) -> None:
    T_world = pose(0.0, 0.0) if wall is None else wall.pose(0.0)
    draft.add(
        Item(category, "", mesh, None), T_world, None, "against" if wall else "on", is_stuff=True
    )


def _choice(rng: np.random.Generator, colours: tuple[Colour, ...]) -> Colour:
    return colours[int(rng.integers(len(colours)))]


def _floor(rng: np.random.Generator, kind: str, width: float, depth: float) -> Solid:
    if kind == "tiles":
        texture = textures.tiles(rng, _choice(rng, STONES))
        material, size = Material((1, 1, 1), texture, shine=0.2, gloss=40), 1.6
    elif kind == "carpet":
        texture = textures.carpet(rng, _choice(rng, PILES))
        material, size = Material((1, 1, 1), texture), 1.5
    else:
        texture = textures.planks(rng, _choice(rng, WOODS))
        material, size = Material((1, 1, 1), texture, shine=0.2, gloss=40), 1.7
    if rng.random() < 0.5:
        floor = sheet(material, (0, 0, 0), (width, 0, 0), (0, depth, 0))
    else:
        floor = sheet(material, (width, 0, 0), (0, depth, 0), (-width, 0, 0))
    return floor.tiled(1 / size, 1 / size)


def _wallpaper(rng: np.random.Generator) -> np.ndarray:
    return textures.wallpaper(rng, _choice(rng, PAINTS), str(rng.choice(textures.WALLPAPERS)))


def _wall(wall: Wall, height: float, cover: Material, holes: list[Hole]) -> Mesh:
    """Build a wall around its holes, with a skirting board, in the wall's own frame."""
    board = Material((0.90, 0.89, 0.86), shine=0.1, gloss=20)
    parts = []
    left = 0.0
    for hole in sorted(holes, key=lambda hole: hole.left):
        parts += _panels(cover, left, hole.left, 0.0, height)
        parts += _panels(cover, hole.left, hole.right, 0.0, hole.bottom)
        parts += _panels(cover, hole.left, hole.right, hole.top, height)
        left = hole.right
    parts += _panels(cover, left, wall.length_m, 0.0, height)
    thick, tall = SKIRTING_M
    middle = (wall.length_m / 2, -thick / 2, tall / 2)
    parts.append(box(board, (wall.length_m, thick, tall), middle))
    return assembled(parts)


def _panels(cover: Material, left: float, right: float, low: float, high: float) -> list[Solid]:
    if right - left < 1e-6 or high - low < 1e-6:
        return []
    return [sheet(cover, (left, 0, low), (right - left, 0, 0), (0, 0, high - low))]
