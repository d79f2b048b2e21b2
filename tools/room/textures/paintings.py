"""Pictures to hang on walls: landscapes, colour fields, circles, grids and flowers."""

from collections.abc import Callable

import numpy as np

from sceneq_core.arrays import Bool, Float64, UInt8
from sceneq_tools.room.mesh import Colour
from sceneq_tools.room.textures.noise import fractal_noise, spread
from sceneq_tools.room.textures.pixels import coordinates, from_hsv, opaque

Shape = tuple[int, int]


def painting(
    rng: np.random.Generator,
    style: str | None = None,
    height_px: int = 384,
    width_px: int = 512,
) -> UInt8:
    """Paint a picture, in a style of ``PAINTINGS`` or in any.

    Raises:
        ValueError: unknown style.
    """
    if style is None:
        style = PAINTINGS[int(rng.integers(len(PAINTINGS)))]
    if style not in _STYLES:
        raise ValueError(f"no painting {style!r}; there are {', '.join(PAINTINGS)}")
    shape = (height_px, width_px)
    image = _STYLES[style](rng, shape)
    strokes = fractal_noise(rng, shape, (24, 12), octaves=4)
    canvas = rng.normal(0.0, 0.012, shape)
    return opaque(image * (1 + 0.16 * (strokes - 0.5) + canvas)[..., None])


def _palette(rng: np.random.Generator, count: int) -> list[Colour]:
    """Neighbouring hues and one opposite, from dark to light."""
    hue = rng.random()
    hues = [hue + rng.uniform(-0.09, 0.09) for _ in range(count - 1)] + [hue + 0.5]
    values = np.linspace(0.35, 0.95, count)
    return [
        from_hsv(h, rng.uniform(0.35, 0.8), float(v)) for h, v in zip(hues, values, strict=True)
    ]


def _landscape(rng: np.random.Generator, shape: Shape) -> Float64:
    """A sky that grows warm towards the horizon, a sun and hills one behind the other."""
    down, right = coordinates(*shape)
    hue = float(rng.choice([0.02, 0.08, 0.55, 0.60]))
    high, low = from_hsv(hue + 0.08, 0.45, 0.75), from_hsv(hue, 0.30, 0.98)
    image = np.array(high) * (1 - down[..., None]) + np.array(low) * down[..., None]
    sun = np.hypot((down - rng.uniform(0.2, 0.45)) * shape[0], (right - rng.random()) * shape[1])
    image[sun < 0.07 * shape[1]] = from_hsv(0.12, 0.25, 1.0)
    land = rng.choice([0.27, 0.38, 0.62, 0.75])
    for layer in range(5):
        ridge = (
            0.5 + 0.1 * layer + 0.22 * (fractal_noise(rng, (1, shape[1]), (1, 3 + layer))[0] - 0.5)
        )
        colour = from_hsv(land + rng.uniform(-0.05, 0.05), 0.25 + 0.1 * layer, 0.75 - 0.12 * layer)
        image[down > ridge] = colour
    return image


def _fields(rng: np.random.Generator, shape: Shape) -> Float64:
    """Soft-edged blocks of colour, one above the other."""
    down, right = coordinates(*shape)
    colours = _palette(rng, 4)
    image = np.empty((*shape, 3))
    image[:] = colours[0]
    wobble = 0.03 * (fractal_noise(rng, shape, (6, 6)) - 0.5)
    edges = np.cumsum([0.06, *(0.88 * rng.dirichlet([5.0] * 3))])
    for colour, top, bottom in zip(colours[1:], edges[:-1], edges[1:], strict=True):
        inside = np.minimum(
            np.minimum(down - top, bottom - 0.03 - down), np.minimum(right, 1 - right) - 0.06
        )
        share = np.clip((inside + wobble) / 0.03, 0, 1)[..., None]
        image = image * (1 - share) + np.array(colour) * share
    return image


def _circles(rng: np.random.Generator, shape: Shape) -> Float64:
    """Discs and bars on a light ground, in the manner of the 1920s."""
    down, right = coordinates(*shape)
    image = np.empty((*shape, 3))
    image[:] = from_hsv(rng.uniform(0.08, 0.16), 0.12, 0.93)
    colours = [*_palette(rng, 5), (0.10, 0.10, 0.12)]
    y, x = down * shape[0] / shape[1], right
    for _ in range(14):
        colour = np.array(colours[int(rng.integers(len(colours)))])
        image[_disc_or_bar(rng, y, x)] = colour
    return image


def _disc_or_bar(rng: np.random.Generator, y: Float64, x: Float64) -> Bool:
    centre_y, centre_x, radius = (
        rng.uniform(0.05, 0.7),
        rng.uniform(0.05, 0.95),
        rng.uniform(0.03, 0.17),
    )
    distance = np.hypot(y - centre_y, x - centre_x)
    kind = rng.integers(3)
    if kind == 0:
        return np.asarray(distance < radius)
    if kind == 1:
        return np.asarray(np.abs(distance - radius) < 0.012)
    angle = rng.uniform(0, np.pi)
    along = (x - centre_x) * np.cos(angle) + (y - centre_y) * np.sin(angle)
    across = (x - centre_x) * np.sin(angle) - (y - centre_y) * np.cos(angle)
    return np.asarray((np.abs(along) < 2 * radius) & (np.abs(across) < 0.010))


def _blocks(rng: np.random.Generator, shape: Shape) -> Float64:
    """White and few strong colours between black lines."""
    down, right = coordinates(*shape)
    image = np.full((*shape, 3), 0.94)
    colours = [(0.82, 0.12, 0.10), (0.10, 0.22, 0.60), (0.95, 0.80, 0.12), (0.94, 0.94, 0.92)]
    rows = np.sort(rng.uniform(0.08, 0.92, 4))
    columns = np.sort(rng.uniform(0.08, 0.92, 4))
    row, column = np.searchsorted(rows, down), np.searchsorted(columns, right)
    for i in range(5):
        for j in range(5):
            image[(row == i) & (column == j)] = colours[
                int(rng.choice(4, p=[0.17, 0.17, 0.16, 0.5]))
            ]
    for line in rows:
        image[np.abs(down - line) < 0.012] = 0.06
    for line in columns:
        image[np.abs(right - line) < 0.009] = 0.06
    return image


def _marble(rng: np.random.Generator, shape: Shape) -> Float64:
    """Poured paint: bands that flow around each other."""
    colours = np.array(_palette(rng, 5))
    bend = fractal_noise(rng, shape, (2, 3), octaves=5)
    flow = spread(fractal_noise(rng, shape, (3, 2), octaves=3) + 1.2 * np.abs(bend - 0.5))
    place = (flow * 9) % (len(colours) - 1)
    band = place.astype(np.int64)
    share = np.clip((place - band - 0.75) / 0.25, 0, 1)[..., None]
    return np.asarray(colours[band] * (1 - share) + colours[band + 1] * share)


def _flowers(rng: np.random.Generator, shape: Shape) -> Float64:
    """Blossoms on stems before a plain ground."""
    down, right = coordinates(*shape)
    image = np.empty((*shape, 3))
    image[:] = from_hsv(rng.random(), 0.22, 0.90)
    y, x = down * shape[0] / shape[1], right
    bottom = shape[0] / shape[1]
    for _ in range(9):
        top, root, lean = rng.uniform(0.12, 0.45), rng.uniform(0.15, 0.85), rng.uniform(-0.15, 0.15)
        rise = np.clip((bottom - y) / (bottom - top), 0, None)
        stem = (np.abs(x - root - lean * rise**2) < 0.006) & (y > top)
        image[stem] = from_hsv(0.33, 0.55, 0.42)
        image = _blossom(rng, image, y - top, x - root - lean)
    return image


def _blossom(rng: np.random.Generator, image: Float64, y: Float64, x: Float64) -> Float64:
    distance, angle = np.hypot(y, x), np.arctan2(y, x)
    petals, size = int(rng.integers(5, 9)), rng.uniform(0.05, 0.09)
    edge = size * (0.72 + 0.28 * np.abs(np.sin(angle * petals / 2)))
    hue = float(rng.choice([0.0, 0.08, 0.13, 0.75, 0.92, 0.6]))
    image[distance < edge] = from_hsv(hue, 0.6, 0.92)
    image[distance < 0.25 * size] = from_hsv(0.13, 0.8, 0.75)
    return image


_STYLES: dict[str, Callable[[np.random.Generator, Shape], Float64]] = {
    "landscape": _landscape,
    "fields": _fields,
    "circles": _circles,
    "blocks": _blocks,
    "marble": _marble,
    "flowers": _flowers,
}
PAINTINGS = tuple(_STYLES)
