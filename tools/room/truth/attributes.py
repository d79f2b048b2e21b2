"""Colour, material and size of a thing, as far as they can be told for sure."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from sceneq_core.arrays import Float32, Float64, Int64
from sceneq_tools.room.mesh import Material, Mesh
from sceneq_tools.room.room import Thing
from sceneq_tools.room.truth.boxes import oriented_box
from sceneq_tools.room.truth.colour_names import COLOURS, CONFUSED, colour_index

PAINTED_SHARE = 0.6
"""A painted thing has the colour of its paint when so much of its visible surface has it."""
MAIN_SHARE = 0.7
"""A thing that is not painted has a colour when so much of its visible surface has it."""
LEAST_SHARE = 0.03
"""Smaller shares of a colour are not worth a word."""
MIXED_MATERIALS = frozenset({"food", "paper", "plant", "glass", "cork", "cardboard", "wicker"})
"""What is made of these has many colours, none, or the one that its kind always has."""
PATTERNED = frozenset(
    {
        "Rubik's cube", "chessboard", "cuckoo clock", "doll", "doll house", "folded clothes",
        "soccer ball", "television", "toy airplane", "toy car", "toy train", "weather station",
        "whiteboard", "xylophone",
    }
)  # fmt: skip
"""Nobody tells these apart by a colour: they show several, or always the same."""
WOOD_TONES = frozenset({"orange", "brown", "yellow"})
"""Wood is wood-coloured: people do not agree on a name."""
UNSURE = frozenset({"beige", "light grey"})
"""Lamplight makes white of them, and them of white."""
RAYS_A_SIDE = 28
DIRECTIONS = tuple(
    (float(np.cos(turn) * np.cos(tilt)), float(np.sin(turn) * np.cos(tilt)), float(np.sin(tilt)))
    for tilt, turns in ((0.15, 8), (0.7, 8), (1.5, 1))
    for turn in np.arange(turns) * (2 * np.pi / turns)
)
"""Where people look from: all around, from level to above; never from below."""


@dataclass(frozen=True, slots=True)
class Attributes:
    """What can be said of a thing.

    ``colour`` is ``None`` unless one name is right for most of what can be seen of it;
    ``colour_shares`` are the shares of the visible surface, biggest first; ``size_m`` is
    (width, depth, height).
    """

    colour: str | None
    colour_shares: tuple[tuple[str, float], ...]
    material: str
    size_m: tuple[float, float, float]

    def share_like(self, colour: str) -> float:
        """Return the share of the surface that people may call ``colour``."""
        return sum(share for name, share in self.colour_shares if name in CONFUSED[colour])


def attributes(thing: Thing) -> Attributes:
    """Return the attributes of a thing from its mesh, its materials and its paint."""
    shares = surface_colours(thing.mesh)
    width, depth, height = (float(x) for x in oriented_box(thing).size.round(4))
    return Attributes(
        colour=_colour(thing, dict(shares)),
        colour_shares=shares,
        material=thing.category.material,
        size_m=(width, depth, height),
    )


@lru_cache(maxsize=1024)
def surface_colours(mesh: Mesh) -> tuple[tuple[str, float], ...]:
    """Return colour names with their share of the surface seen from outside, biggest first.

    Parallel rays from all sides find what is visible, so the inside of a drawer does not count.
    """
    face, uv = _visible(mesh)
    srgb, alpha = _albedo(mesh, face, uv)
    solid = (alpha >= 0.5).astype(np.float64)
    count: Float64 = np.bincount(colour_index(srgb), solid, len(COLOURS)).astype(np.float64)
    shares = (count / max(float(count.sum()), 1e-12)).tolist()
    ranked = sorted(zip(COLOURS, shares, strict=True), key=lambda pair: -pair[1])
    return tuple((name, round(share, 3)) for name, share in ranked if share >= LEAST_SHARE)


def _colour(thing: Thing, shares: dict[str, float]) -> str | None:
    if thing.tint is not None:
        painted = "grey" if thing.tint == "gray" else thing.tint
        if painted not in CONFUSED:
            return None
        like = sum(share for name, share in shares.items() if name in CONFUSED[painted])
        return painted if like >= PAINTED_SHARE else None
    if not shares or thing.category.material in MIXED_MATERIALS or thing.label in PATTERNED:
        return None
    name = next(iter(shares))
    unsure = UNSURE | WOOD_TONES if thing.category.material == "wood" else UNSURE
    return name if shares[name] >= MAIN_SHARE and name not in unsure else None


def _visible(mesh: Mesh) -> tuple[Int64, Float64]:
    """Return the face (N,) and barycentric u, v (N, 2) of every ray that hits from outside."""
    import open3d as o3d

    tensor = o3d.core.Tensor.from_numpy
    scene = o3d.t.geometry.RaycastingScene(nthreads=1)
    vertices = np.ascontiguousarray(mesh.vertices, np.float32)
    scene.add_triangles(tensor(vertices), tensor(mesh.faces.astype(np.uint32)))
    low, high = vertices.min(0), vertices.max(0)
    radius = float(np.linalg.norm(high - low)) / 2 + 1e-3
    centre = ((low + high) / 2).astype(np.float32, copy=False)
    rays = np.concatenate([_parallel_rays(centre, radius, d) for d in DIRECTIONS])
    hit = scene.cast_rays(tensor(rays))
    face = hit["primitive_ids"].numpy().astype(np.int64)
    found = hit["t_hit"].numpy() < np.inf
    uv = hit["primitive_uvs"].numpy()[found].astype(np.float64)
    return face[found], uv


def _parallel_rays(centre: Float32, radius: float, towards: tuple[float, ...]) -> Float32:
    """Return rays (N, 6) that fall on a ball from direction ``towards``."""
    outward = np.asarray(towards)
    side = np.cross(outward, (0.0, 0.0, 1.0) if abs(outward[2]) < 0.99 else (1.0, 0.0, 0.0))
    side /= np.linalg.norm(side)
    steps = ((np.arange(RAYS_A_SIDE) + 0.5) / RAYS_A_SIDE * 2 - 1) * radius
    a, b = np.meshgrid(steps, steps)
    plane = a[..., None] * side + b[..., None] * np.cross(outward, side)
    origins = (centre + 2 * radius * outward + plane).reshape(-1, 3)
    rays = np.hstack([origins, np.broadcast_to(-outward, origins.shape)])
    return rays.astype(np.float32)


def _albedo(mesh: Mesh, face: Int64, barycentric: Float64) -> tuple[Float64, Float64]:
    """Return sRGB (N, 3) and alpha (N,) of the surface at points on faces."""
    b1, b2 = barycentric.T
    corner = mesh.uv[mesh.faces[face]].astype(np.float64)
    weights = np.stack([1 - b1 - b2, b1, b2], axis=1)
    uv = (corner * weights[..., None]).sum(1)
    srgb, alpha = np.empty((len(face), 3)), np.empty(len(face))
    material_of = mesh.material_index[face]
    for index in np.unique(material_of):
        rows = material_of == index
        srgb[rows], alpha[rows] = _sample(mesh.materials[index], uv[rows])
    return srgb, alpha


def _sample(material: Material, uv: Float64) -> tuple[Float64, Float64]:
    colour = np.asarray(material.colour, np.float64)
    if material.texture is None:
        return np.tile(colour, (len(uv), 1)), np.full(len(uv), material.opacity)
    height, width = material.texture.shape[:2]
    column = np.floor(uv[:, 0] * width).astype(np.int64) % width
    row = np.floor((1 - uv[:, 1]) * height).astype(np.int64) % height
    texel = material.texture[row, column] / 255.0
    return texel[:, :3] * colour, texel[:, 3] * material.opacity
