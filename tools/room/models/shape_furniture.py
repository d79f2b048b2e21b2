"""Simple tables, shelves and machines: lists of solids, metres, front towards -y."""

from collections.abc import Sequence

import numpy as np

from sceneq_tools.room.mesh import Colour, Material
from sceneq_tools.room.models.finishes import (
    black_plastic,
    leaves,
    oak,
    pictured,
    plain,
    steel,
    walnut,
    white_enamel,
    worktop,
)
from sceneq_tools.room.models.shape_seats import legs
from sceneq_tools.room.models.solids import (
    Solid,
    ball,
    box,
    cylinder,
    lathe,
    picture,
    standing_box,
    tube,
)
from sceneq_tools.room.textures import textures


def table(width: float, depth: float, height: float, wood: Material | None = None) -> list[Solid]:
    """A slab on four legs."""
    wood = oak() if wood is None else wood
    slab = standing_box(wood, (width, depth, 0.035), (0, 0, height - 0.035))
    return [slab, *legs(wood, width - 0.06, depth - 0.06, height - 0.035, 0.06)]


def dining_table() -> list[Solid]:
    """For four."""
    return table(1.4, 0.85, 0.75)


def coffee_table() -> list[Solid]:
    """Low, with a shelf underneath."""
    return [
        *table(1.1, 0.6, 0.45, walnut()),
        standing_box(walnut(), (1.0, 0.5, 0.02), (0, 0, 0.14)),
    ]


def desk() -> list[Solid]:
    """A slab, a side panel and a box of drawers."""
    parts = [
        standing_box(oak(), (1.4, 0.7, 0.03), (0, 0, 0.71)),
        standing_box(oak(), (0.03, 0.66, 0.71), (-0.68, 0, 0)),
    ]
    return parts + [part.moved(x=0.47) for part in cabinet(0.42, 0.64, 0.71, oak(), (1, 3))]


def cabinet(
    width: float, depth: float, height: float, body: Material, fronts: tuple[int, int]
) -> list[Solid]:
    """A block with columns x rows of doors or drawers, each with a handle."""
    columns, rows = fronts
    parts = [standing_box(body, (width, depth - 0.02, height), (0, 0.01, 0))]
    wide, high = width / columns, (height - 0.02) / rows
    for column in range(columns):
        for row in range(rows):
            x, z = (column + 0.5) * wide - width / 2, (row + 0.5) * high + 0.01
            parts.append(box(body, (wide - 0.012, 0.02, high - 0.012), (x, -depth / 2 + 0.01, z)))
            parts.append(_handle(x, -depth / 2, z, wide, high))
    return parts


def _handle(x: float, y: float, z: float, wide: float, high: float) -> Solid:
    """Lying on drawers, upright on doors."""
    if high > 1.2 * wide:
        return box(steel(), (0.014, 0.02, 0.14), (x + wide / 2 - 0.05, y - 0.01, z))
    return box(steel(), (0.14, 0.02, 0.014), (x, y - 0.01, z))


def shelves(width: float, depth: float, height: float, boards: int, wood: Material) -> list[Solid]:
    """An open case."""
    parts = [
        standing_box(wood, (0.02, depth, height), (x, 0, 0))
        for x in (-width / 2 + 0.01, width / 2 - 0.01)
    ]
    parts.append(standing_box(wood, (width, 0.01, height), (0, depth / 2 - 0.005, 0)))
    board = standing_box(wood, (width - 0.04, depth - 0.01, 0.02), (0, -0.005, 0))
    return parts + [board.moved(z=float(z)) for z in np.linspace(0.04, height - 0.02, boards)]


def bookcase() -> list[Solid]:
    """Five shelves, books on the uppermost but one."""
    books = book_row(np.random.default_rng(7), 0.74)
    return [*shelves(0.85, 0.32, 1.9, 6, oak()), *(part.moved(z=1.53) for part in books)]


def book_row(rng: np.random.Generator, length: float) -> list[Solid]:
    """Books side by side along x, spines towards -y, standing on z = 0."""
    parts, x = [], -length / 2
    while x < length / 2 - 0.05:
        thick, high = rng.uniform(0.02, 0.05), rng.uniform(0.20, 0.28)
        colour: Colour = tuple(rng.uniform(0.1, 0.8, 3))
        parts.append(standing_box(plain(colour), (thick, 0.18, high), (x + thick / 2, 0.0, 0)))
        x += thick + 0.002
    return parts


def tv_stand() -> list[Solid]:
    """Low, with two doors."""
    return cabinet(1.4, 0.42, 0.48, walnut(), (2, 1))


def dresser() -> list[Solid]:
    """Two columns of three drawers."""
    return cabinet(1.2, 0.48, 0.85, oak(), (2, 3))


def nightstand() -> list[Solid]:
    """Two drawers."""
    return cabinet(0.45, 0.40, 0.50, oak(), (1, 2))


def wardrobe() -> list[Solid]:
    """Two tall doors."""
    return cabinet(1.1, 0.60, 2.0, oak(), (2, 1))


def filing_cabinet() -> list[Solid]:
    """Metal, three drawers."""
    return cabinet(0.42, 0.55, 0.72, plain((0.55, 0.58, 0.60)), (1, 3))


def _counter(width: float, fronts: tuple[int, int], body: Material | None = None) -> list[Solid]:
    body = plain((0.86, 0.85, 0.80)) if body is None else body
    return [
        standing_box(black_plastic(), (width, 0.52, 0.10), (0, 0.04, 0)),
        *(part.moved(z=0.10) for part in cabinet(width, 0.60, 0.76, body, fronts)),
        standing_box(worktop(), (width, 0.62, 0.04), (0, -0.01, 0.86)),
    ]


def kitchen_cabinet() -> list[Solid]:
    """A door under a worktop, 60 cm."""
    return _counter(0.6, (1, 1))


def kitchen_drawers() -> list[Solid]:
    """Three drawers under a worktop, 60 cm."""
    return _counter(0.6, (1, 3))


def kitchen_sink() -> list[Solid]:
    """A basin and a tap in a worktop."""
    rim = (0.24, 0.905), (0.23, 0.925), (0.21, 0.925), (0.20, 0.906), (0.0, 0.904)
    bend = np.linspace(0, np.pi, 10)
    spout = [(0, 0.20 - 0.08 * (1 - np.cos(a)), 1.12 + 0.08 * np.sin(a)) for a in bend]
    tap = tube(steel(), [(0, 0.20, 0.9), (0, 0.20, 1.0), *spout], 0.013)
    return [*_counter(0.8, (2, 1)), lathe(steel(), rim), tap]


def upper_cabinet() -> list[Solid]:
    """Two doors, hangs on the wall."""
    return cabinet(0.6, 0.35, 0.70, plain((0.86, 0.85, 0.80)), (2, 1))


def range_hood() -> list[Solid]:
    """A canopy and a chimney."""
    return [
        standing_box(steel(), (0.60, 0.48, 0.06), (0, 0, 0)),
        standing_box(steel(), (0.24, 0.24, 0.45), (0, 0.12, 0.06)),
    ]


def stove() -> list[Solid]:
    """Four plates, knobs, an oven with a window."""
    enamel, black = white_enamel(), black_plastic()
    parts = [
        standing_box(enamel, (0.60, 0.60, 0.88), (0, 0, 0)),
        standing_box(black, (0.58, 0.56, 0.01), (0, 0, 0.88)),
        box(black, (0.44, 0.01, 0.34), (0, -0.305, 0.42)),
        box(steel(), (0.46, 0.03, 0.02), (0, -0.315, 0.68)),
    ]
    ring = plain((0.28, 0.16, 0.14))
    parts += [
        cylinder(ring, 0.09, 0.004, (x, y, 0.89)) for x in (-0.14, 0.14) for y in (-0.13, 0.13)
    ]
    knob = cylinder(black, 0.02, 0.025, (0, 0, 0)).turned("x", 90)
    return parts + [knob.moved(x, -0.30, 0.79) for x in (-0.2, -0.1, 0.1, 0.2)]


def refrigerator() -> list[Solid]:
    """A freezer above a fridge."""
    enamel = white_enamel()
    parts = [standing_box(enamel, (0.62, 0.58, 1.68), (0, 0.03, 0.04))]
    parts.append(standing_box(black_plastic(), (0.58, 0.50, 0.04), (0, 0, 0)))
    for low, high in ((0.06, 1.12), (1.14, 1.72)):
        parts.append(standing_box(enamel, (0.62, 0.06, high - low), (0, -0.30, low)))
        parts.append(
            standing_box(steel(), (0.02, 0.03, 0.30), (0.26, -0.345, (low + high) / 2 - 0.15))
        )
    return parts


def washing_machine() -> list[Solid]:
    """A block with a porthole."""
    rim = lathe(steel(), [(0.12, 0.0), (0.20, 0.0), (0.20, 0.03), (0.13, 0.03)]).turned("x", 90)
    glass = cylinder(plain((0.12, 0.14, 0.17), 0.5), 0.13, 0.02, (0, 0, 0)).turned("x", 90)
    return [
        standing_box(white_enamel(), (0.60, 0.58, 0.85), (0, 0.01, 0)),
        box(plain((0.75, 0.76, 0.77)), (0.56, 0.01, 0.10), (0, -0.285, 0.77)),
        rim.moved(0, -0.28, 0.42),
        glass.moved(0, -0.28, 0.42),
    ]


def television() -> list[Solid]:
    """A flat screen on a foot."""
    black = black_plastic()
    return [
        standing_box(black, (0.40, 0.20, 0.015), (0, 0, 0)),
        standing_box(black, (0.06, 0.04, 0.08), (0, 0.02, 0.01)),
        standing_box(black, (1.00, 0.05, 0.58), (0, 0, 0.08)),
        picture(plain((0.04, 0.05, 0.07), 0.6, 80.0), 0.97, 0.54, (0, -0.0255, 0.37)),
    ]


def rug(
    size: Sequence[float] = (2.3, 1.6), style: str = "medallion", seed: int = 11
) -> list[Solid]:
    """A sheet of 8 mm with a woven pattern."""
    woven = pictured(textures.rug(np.random.default_rng(seed), style), shine=0.0)
    wide, deep = size
    block = standing_box(woven, (wide, deep, 0.008), (0, 0, 0))
    return [block.tiled(1 / wide, 1 / deep)]


def potted_plant() -> list[Solid]:
    """Leaves that lean outwards from a clay pot."""
    clay = plain((0.68, 0.36, 0.22), 0.0)
    pot = [(0.0, 0.0), (0.12, 0.0), (0.16, 0.26), (0.14, 0.26), (0.13, 0.22), (0.0, 0.22)]
    parts = [lathe(clay, pot)]
    for i in range(14):
        length, lean = 0.55 + 0.05 * (i % 4), 18.0 + 9.0 * (i % 5)
        leaf = _leaf(length).turned("y", lean).turned("z", i * 137.5)
        parts.append(leaf.moved(z=0.22))
    return parts


def _leaf(length: float) -> Solid:
    """A thin pointed blade, upright."""
    profile = [(0.0, 0.0), (0.01, 0.1), (0.06, 0.55 * length), (0.05, 0.75 * length), (0.0, length)]
    round_one = lathe(leaves(), profile, steps=10, crease_deg=80.0)
    return Solid(
        round_one.vertices * (0.12, 1.0, 1.0),
        round_one.normals,
        round_one.uv,
        round_one.faces,
        leaves(),
    )


def table_lamp() -> list[Solid]:
    """A ball foot under a shade."""
    shade = lathe(plain((0.93, 0.88, 0.76), 0.0), [(0.15, 0.24), (0.10, 0.42)])
    foot = plain((0.20, 0.42, 0.46), 0.4)
    return [
        cylinder(foot, 0.07, 0.02, (0, 0, 0)),
        ball(foot, 0.08, (0, 0, 0.10)),
        cylinder(steel(), 0.01, 0.14, (0, 0, 0.17)),
        shade,
    ]
