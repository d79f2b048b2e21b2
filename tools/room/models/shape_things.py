"""Simple small things: lists of solids, metres, front towards -y."""

import numpy as np

from sceneq_tools.room.mesh import Material
from sceneq_tools.room.models.finishes import black_plastic, oak, pictured, plain, steel, walnut
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


def _vessel(material: Material, outside: list[tuple[float, float]], wall: float) -> Solid:
    """A lathe with the same profile inside, ``wall`` thinner, open at the top."""
    inside = [(max(r - wall, 0.0), max(z, wall)) for r, z in reversed(outside) if r > 0]
    return lathe(material, [(0.0, outside[0][1]), *outside, *inside, (0.0, wall)])


def _ring(material: Material, width: float, height: float, thick: float) -> Solid:
    """Half an ellipse in the x-z plane, open towards -x: a handle."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 13)
    path = np.stack([width * np.cos(angle), np.zeros(13), height * np.sin(angle)], axis=1)
    return tube(material, path, thick)


def mug() -> list[Solid]:
    """A cylinder with a handle."""
    glaze = plain((0.85, 0.84, 0.80), 0.4, 40.0)
    body = _vessel(glaze, [(0.036, 0.0), (0.042, 0.006), (0.042, 0.095)], 0.004)
    return [body, _ring(glaze, 0.028, 0.028, 0.006).moved(0.040, 0, 0.048)]


def plastic_cup() -> list[Solid]:
    """A wide rim on a narrow foot."""
    return [_vessel(plain((0.75, 0.30, 0.20)), [(0.028, 0.0), (0.040, 0.11)], 0.002)]


def bowl() -> list[Solid]:
    """Half a ball with a foot."""
    angle = np.linspace(0.25, np.pi / 2, 9)
    curve = [(0.12 * float(np.sin(a)), 0.015 + 0.085 * (1 - float(np.cos(a)))) for a in angle]
    glaze = plain((0.75, 0.78, 0.80), 0.4, 40.0)
    return [_vessel(glaze, [(0.045, 0.0), (0.045, 0.012), *curve], 0.005)]


def plate() -> list[Solid]:
    """A flat disc with a rim."""
    glaze = plain((0.90, 0.89, 0.86), 0.4, 40.0)
    return [_vessel(glaze, [(0.07, 0.0), (0.09, 0.004), (0.13, 0.020)], 0.004)]


def bottle() -> list[Solid]:
    """Wine: shoulders, neck and a paper label."""
    glass = plain((0.08, 0.20, 0.10), 0.6, 80.0)
    profile = [
        (0.0, 0.0),
        (0.037, 0.0),
        (0.038, 0.18),
        (0.034, 0.20),
        (0.015, 0.23),
        (0.014, 0.30),
        (0.0, 0.30),
    ]
    paper = plain((0.88, 0.84, 0.72), 0.0)
    return [lathe(glass, profile, crease_deg=50.0), lathe(paper, [(0.0385, 0.06), (0.0385, 0.14)])]


def vase() -> list[Solid]:
    """A belly and a lip."""
    height = np.linspace(0.0, 0.30, 16)
    belly = 0.06 + 0.045 * np.sin(height / 0.30 * np.pi * 1.25) + 0.01
    outline = [(float(r), float(z)) for r, z in zip(belly, height, strict=True)]
    return [_vessel(plain((0.30, 0.45, 0.62), 0.5, 50.0), outline, 0.006)]


def kettle() -> list[Solid]:
    """A can with a lid, a spout and a handle."""
    body = [(0.0, 0.0), (0.085, 0.0), (0.09, 0.02), (0.07, 0.17), (0.05, 0.19), (0.0, 0.195)]
    handle = _ring(black_plastic(), 0.055, 0.07, 0.010).moved(0.07, 0, 0.11)
    spout = tube(steel(), [(-0.07, 0, 0.09), (-0.10, 0, 0.13), (-0.125, 0, 0.165)], 0.015)
    knob = ball(black_plastic(), 0.015, (0, 0, 0.205), steps=12)
    return [lathe(steel(), body), handle, spout, knob]


def cooking_pot() -> list[Solid]:
    """A pot with a lid and two handles."""
    parts = [
        lathe(
            steel(),
            [(0.0, 0.0), (0.12, 0.0), (0.12, 0.13), (0.125, 0.135), (0.05, 0.155), (0.0, 0.158)],
        ),
        ball(black_plastic(), 0.018, (0, 0, 0.17), steps=12),
    ]
    handle = _ring(black_plastic(), 0.035, 0.03, 0.008).turned("x", 90).moved(0.118, 0, 0.105)
    return [*parts, handle, handle.turned("z", 180)]


def apple() -> list[Solid]:
    """A fruit with a stalk."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 15)
    radius = 0.038 * np.cos(angle) ** 0.75
    height = 0.034 + 0.034 * np.sin(angle) - 0.010 * np.cos(angle) ** 6 * np.sin(angle)
    outline = [(float(r), float(z)) for r, z in zip(radius, height, strict=True)]
    outline[0], outline[-1] = (0.0, outline[0][1]), (0.0, outline[-1][1])
    stalk = tube(plain((0.30, 0.20, 0.10)), [(0, 0, 0.060), (0.004, 0, 0.08)], 0.002)
    return [lathe(plain((0.72, 0.12, 0.10), 0.3), outline), stalk]


def book() -> list[Solid]:
    """A cover around pages, lying."""
    cover, paper = plain((0.55, 0.14, 0.16)), plain((0.92, 0.90, 0.82), 0.0)
    return [
        standing_box(cover, (0.16, 0.22, 0.003), (0, 0, 0)),
        standing_box(paper, (0.152, 0.21, 0.022), (0.002, 0, 0.003)),
        standing_box(cover, (0.16, 0.22, 0.003), (0, 0, 0.025)),
        standing_box(cover, (0.003, 0.22, 0.025), (-0.079, 0, 0.0015)),
    ]


def laptop() -> list[Solid]:
    """Opened, screen towards -y."""
    grey, screen = plain((0.62, 0.63, 0.65), 0.3), plain((0.16, 0.30, 0.50), 0.4)
    lid = [
        box(grey, (0.34, 0.008, 0.22), (0, 0, 0.11)),
        picture(screen, 0.32, 0.20, (0, -0.0045, 0.11)),
    ]
    return [
        standing_box(grey, (0.34, 0.24, 0.018), (0, 0, 0)),
        standing_box(black_plastic(), (0.30, 0.11, 0.002), (0, 0.04, 0.018)),
        standing_box(plain((0.5, 0.5, 0.52)), (0.10, 0.06, 0.002), (0, -0.07, 0.018)),
        *(part.turned("x", -15).moved(0, 0.118, 0.017) for part in lid),
    ]


def microwave() -> list[Solid]:
    """A box with a window and knobs."""
    black = black_plastic()
    knob = cylinder(black, 0.018, 0.02, (0, 0, 0)).turned("x", 90)
    return [
        standing_box(plain((0.82, 0.82, 0.80), 0.2), (0.46, 0.34, 0.27), (0, 0, 0.01)),
        standing_box(black, (0.40, 0.28, 0.01), (0, 0, 0)),
        picture(black, 0.30, 0.19, (-0.06, -0.1705, 0.145)),
        box(steel(), (0.015, 0.02, 0.18), (0.105, -0.18, 0.145)),
        knob.moved(0.17, -0.17, 0.19),
        knob.moved(0.17, -0.17, 0.10),
    ]


def toaster() -> list[Solid]:
    """Two slots and a lever."""
    black = black_plastic()
    parts = [standing_box(steel(), (0.28, 0.17, 0.18), (0, 0, 0.01))]
    parts.append(standing_box(black, (0.25, 0.14, 0.01), (0, 0, 0)))
    parts += [standing_box(black, (0.20, 0.028, 0.002), (0, y, 0.19)) for y in (-0.035, 0.035)]
    return [*parts, box(black, (0.02, 0.03, 0.015), (0.15, 0, 0.13))]


def speaker() -> list[Solid]:
    """A box with two cones."""
    black = black_plastic()
    cone = lathe(plain((0.25, 0.25, 0.27)), [(0.07, 0.0), (0.07, 0.006), (0.0, 0.001)]).turned(
        "x", 90
    )
    return [
        standing_box(walnut(), (0.20, 0.22, 0.34), (0, 0, 0)),
        picture(black, 0.18, 0.32, (0, -0.1105, 0.17)),
        cone.moved(0, -0.111, 0.12),
        Solid(cone.vertices * 0.5, cone.normals, cone.uv, cone.faces, cone.material).moved(
            0, -0.111, 0.26
        ),
    ]


def clock() -> list[Solid]:
    """A round face on two feet."""
    red, black = plain((0.70, 0.12, 0.10), 0.4), black_plastic()
    case = cylinder(red, 0.055, 0.04, (0, 0, 0)).turned("x", 90).moved(0, 0.02, 0.065)
    face = (
        cylinder(plain((0.95, 0.94, 0.90)), 0.048, 0.002, (0, 0, 0))
        .turned("x", 90)
        .moved(0, -0.02, 0.065)
    )
    return [
        case,
        face,
        box(black, (0.004, 0.002, 0.036), (0, -0.0235, 0.082)),
        box(black, (0.026, 0.002, 0.004), (0.012, -0.0235, 0.065)),
        *(ball(black, 0.010, (x, 0, 0.010), steps=10) for x in (-0.035, 0.035)),
    ]


def picture_frame() -> list[Solid]:
    """A small painting that leans back on the table."""
    image = pictured(textures.painting(np.random.default_rng(21), "landscape", 192, 256))
    parts = [
        standing_box(oak(), (0.20, 0.015, 0.16), (0, 0, 0)),
        picture(image, 0.17, 0.13, (0, -0.008, 0.08)),
    ]
    leaning = [part.turned("x", -10) for part in parts]
    low = min(float(part.vertices[:, 2].min()) for part in leaning)
    return [part.moved(z=-low) for part in leaning]


def candle() -> list[Solid]:
    """Wax with a wick on a saucer."""
    wax = plain((0.90, 0.86, 0.74), 0.1)
    return [
        cylinder(steel(), 0.05, 0.008, (0, 0, 0)),
        cylinder(wax, 0.03, 0.12, (0, 0, 0.008)),
        cylinder(black_plastic(), 0.002, 0.012, (0, 0, 0.128), steps=8),
    ]


def cardboard_box() -> list[Solid]:
    """Closed, with a strip of tape."""
    board, tape = plain((0.68, 0.52, 0.34), 0.0), plain((0.78, 0.68, 0.48), 0.2)
    return [
        standing_box(board, (0.45, 0.35, 0.30), (0, 0, 0)),
        standing_box(tape, (0.452, 0.05, 0.0015), (0, 0, 0.30)),
    ]


def gift_box() -> list[Solid]:
    """Wrapped, with a ribbon and a bow."""
    paper, ribbon = plain((0.55, 0.18, 0.48)), plain((0.93, 0.80, 0.30), 0.3)
    bow = _ring(ribbon, 0.03, 0.03, 0.006).turned("x", 90)
    return [
        standing_box(paper, (0.20, 0.16, 0.14), (0, 0, 0)),
        standing_box(ribbon, (0.025, 0.164, 0.142), (0, 0, 0)),
        standing_box(ribbon, (0.204, 0.025, 0.142), (0, 0, 0)),
        *(bow.turned("y", 30).turned("z", a).moved(z=0.15) for a in (0, 180)),
    ]


def suitcase() -> list[Solid]:
    """Upright, with a handle and four wheels."""
    shell, black = plain((0.15, 0.30, 0.55), 0.3), black_plastic()
    ribs = [
        standing_box(shell, (0.03, 0.26, 0.58), (x, 0, 0.05)) for x in (-0.14, -0.05, 0.05, 0.14)
    ]
    wheels = [ball(black, 0.025, (x, y, 0.025), 10) for x in (-0.15, 0.15) for y in (-0.08, 0.08)]
    handle = _ring(black, 0.05, 0.07, 0.01).turned("y", -90).moved(z=0.63)
    return [standing_box(shell, (0.40, 0.24, 0.60), (0, 0, 0.04)), *ribs, *wheels, handle]


def trash_can() -> list[Solid]:
    """An open bin."""
    return [_vessel(plain((0.45, 0.47, 0.48), 0.3), [(0.11, 0.0), (0.14, 0.35)], 0.004)]


def basketball() -> list[Solid]:
    """Orange with three seams."""
    skin, seam = plain((0.80, 0.38, 0.12), 0.1), plain((0.08, 0.06, 0.05), 0.0)
    ring = lathe(seam, [(0.1195, -0.003), (0.1215, -0.003), (0.1215, 0.003), (0.1195, 0.003)])
    turns = [ring, ring.turned("x", 90), ring.turned("y", 90)]
    return [ball(skin, 0.12, (0, 0, 0.1215)), *(part.moved(z=0.1215) for part in turns)]


def fire_extinguisher() -> list[Solid]:
    """A red flask with a hose."""
    red, black = plain((0.75, 0.08, 0.07), 0.4), black_plastic()
    flask = [
        (0.0, 0.0),
        (0.07, 0.0),
        (0.075, 0.02),
        (0.075, 0.38),
        (0.05, 0.44),
        (0.02, 0.46),
        (0.0, 0.46),
    ]
    hose = [(0, 0, 0.48), (0.07, 0, 0.47), (0.10, 0, 0.38), (0.095, 0, 0.24)]
    return [
        lathe(red, flask),
        cylinder(black, 0.02, 0.05, (0, 0, 0.455)),
        tube(black, hose, 0.011),
        lathe(plain((0.92, 0.91, 0.86), 0.0), [(0.0755, 0.14), (0.0755, 0.28)]),
    ]


def wall_clock() -> list[Solid]:
    """Round, its back at +y."""
    black = black_plastic()
    rim = cylinder(walnut(), 0.15, 0.04, (0, 0, 0)).turned("x", 90).moved(0, 0.02, 0.15)
    face = cylinder(plain((0.95, 0.94, 0.90)), 0.13, 0.002, (0, 0, 0)).turned("x", 90)
    marks = [
        box(black, (0.008, 0.002, 0.02), (0, -0.0235, 0.115)).turned("y", 30.0 * i).moved(z=0.15)
        for i in range(12)
    ]
    hands = [
        box(black, (0.008, 0.002, 0.09), (0, -0.0235, 0.19)),
        box(black, (0.065, 0.002, 0.010), (0.03, -0.0235, 0.15)),
    ]
    return [rim, face.moved(0, -0.02, 0.15), *marks, *hands]
