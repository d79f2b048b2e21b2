"""Simple seats and beds: lists of solids, metres, front towards -y."""

from sceneq_tools.room.mesh import Material
from sceneq_tools.room.models.finishes import bed_linen, black_plastic, oak, plain, steel, walnut
from sceneq_tools.room.models.solids import Solid, ball, cylinder, lathe, standing_box, tube


def legs(
    material: Material, width: float, depth: float, height: float, thick: float
) -> list[Solid]:
    """Four square posts at the corners of a footprint."""
    x, y = (width - thick) / 2, (depth - thick) / 2
    places = [(-x, -y), (x, -y), (x, y), (-x, y)]
    return [standing_box(material, (thick, thick, height), (*place, 0.0)) for place in places]


def sofa(width: float = 2.0) -> list[Solid]:
    """Cushions side by side between two arms."""
    cloth, cushion = plain((0.36, 0.42, 0.50), 0.0), plain((0.42, 0.48, 0.56), 0.0)
    seats = max(1, round((width - 0.4) / 0.75))
    wide = (width - 0.4) / seats
    parts = legs(walnut(), width - 0.1, 0.75, 0.08, 0.06)
    parts += [
        standing_box(cloth, (width, 0.88, 0.22), (0, 0, 0.08)),
        standing_box(cloth, (width, 0.20, 0.52), (0, 0.34, 0.30)),
        standing_box(cloth, (0.20, 0.68, 0.32), (-(width - 0.2) / 2, -0.1, 0.30)),
        standing_box(cloth, (0.20, 0.68, 0.32), ((width - 0.2) / 2, -0.1, 0.30)),
    ]
    for i in range(seats):
        x = (i - (seats - 1) / 2) * wide
        parts.append(standing_box(cushion, (wide - 0.015, 0.66, 0.15), (x, -0.09, 0.30)))
        back = standing_box(cushion, (wide - 0.03, 0.14, 0.40), (0, 0, 0)).turned("x", -8)
        parts.append(back.moved(x, 0.15, 0.46))
    return parts


def armchair() -> list[Solid]:
    """A sofa for one."""
    return sofa(width=0.95)


def chair() -> list[Solid]:
    """Four legs, a seat, two posts and two slats."""
    wood = oak()
    parts = legs(wood, 0.42, 0.42, 0.44, 0.04)
    parts.append(standing_box(wood, (0.45, 0.45, 0.03), (0, 0, 0.44)))
    parts += [standing_box(wood, (0.04, 0.03, 0.45), (x, 0.19, 0.47)) for x in (-0.19, 0.19)]
    parts += [standing_box(wood, (0.36, 0.02, 0.09), (0, 0.19, z)) for z in (0.62, 0.80)]
    return parts


def stool() -> list[Solid]:
    """A round seat on four legs."""
    paint = plain((0.80, 0.80, 0.78))
    return [*legs(walnut(), 0.28, 0.28, 0.43, 0.035), cylinder(paint, 0.19, 0.04, (0, 0, 0.43))]


def office_chair() -> list[Solid]:
    """Five feet, a column, a seat, a back and arms."""
    cloth, black = plain((0.16, 0.18, 0.22), 0.0), black_plastic()
    foot = standing_box(black, (0.30, 0.05, 0.04), (0.15, 0, 0.05))
    wheel = ball(black, 0.03, (0.28, 0, 0.03), steps=10)
    parts = [part.turned("z", 72.0 * i) for i in range(5) for part in (foot, wheel)]
    parts += [
        cylinder(steel(), 0.03, 0.36, (0, 0, 0.07)),
        standing_box(cloth, (0.50, 0.48, 0.09), (0, 0, 0.43)),
        standing_box(black, (0.06, 0.04, 0.30), (0, 0.26, 0.40)),
        standing_box(cloth, (0.46, 0.07, 0.50), (0, 0.25, 0.56)),
    ]
    parts += [standing_box(black, (0.05, 0.26, 0.03), (x, 0, 0.66)) for x in (-0.27, 0.27)]
    parts += [standing_box(black, (0.03, 0.03, 0.20), (x, 0.05, 0.47)) for x in (-0.27, 0.27)]
    return parts


def bed(width: float = 1.6) -> list[Solid]:
    """Frame, mattress, quilt, pillows; the head is at the back."""
    wood, quilt = walnut(), plain((0.33, 0.45, 0.58), 0.0)
    parts = legs(wood, width, 2.08, 0.15, 0.08)
    parts += [
        standing_box(wood, (width + 0.04, 2.12, 0.16), (0, 0, 0.12)),
        standing_box(wood, (width + 0.04, 0.06, 0.95), (0, 1.06, 0)),
        standing_box(bed_linen(), (width - 0.04, 2.02, 0.20), (0, 0, 0.28)),
        standing_box(quilt, (width + 0.02, 1.45, 0.19), (0, -0.30, 0.32)),
    ]
    spots = (-width / 4, width / 4) if width > 1.2 else (0.0,)
    return parts + [pillow(bed_linen()).moved(x, 0.72, 0.48) for x in spots]


def pillow(cloth: Material) -> Solid:
    """A flattened ball, 60 x 40 cm, standing on z = 0."""
    profile = [(0.0, 0.0), (0.17, 0.015), (0.20, 0.06), (0.17, 0.105), (0.0, 0.12)]
    round_one = lathe(cloth, profile, steps=24, crease_deg=80.0)
    return _stretched(round_one, 1.5, 1.0)


def _stretched(solid: Solid, x: float, y: float) -> Solid:
    """Scale sideways; good enough for normals of soft things."""
    return Solid(solid.vertices * (x, y, 1.0), solid.normals, solid.uv, solid.faces, solid.material)


def floor_lamp() -> list[Solid]:
    """A foot, a pole and a shade."""
    shade = [(0.14, 1.60), (0.20, 1.35)][::-1]
    cloth = plain((0.92, 0.86, 0.70), 0.0)
    return [
        cylinder(steel(), 0.15, 0.025, (0, 0, 0)),
        tube(steel(), [(0, 0, 0.02), (0, 0, 0.8), (0, 0, 1.5)], 0.012),
        lathe(cloth, shade),
        ball(Material(colour=(1.0, 0.95, 0.85), emission=2.0), 0.05, (0, 0, 1.48), steps=12),
    ]
