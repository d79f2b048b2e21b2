"""Triangles with materials: what every model, wall and picture is made of."""

from dataclasses import dataclass

from sceneq_core.arrays import Float32, Int32, UInt8

Colour = tuple[float, float, float]
"""sRGB, 0 to 1."""


@dataclass(frozen=True, slots=True, eq=False)
class Material:
    """How a surface looks.

    Attributes:
        colour: sRGB; multiplies the texture where there is one.
        texture: uint8 (h, w, 4) sRGB + alpha, row 0 at v = 1 (top), repeated outside 0..1; or
            ``None``. Alpha below one half cuts the surface out.
        opacity: 1 solid, below one half glass: seen through, but it has a depth and an instance.
        shine: strength of the highlight, 0 to 1; ``gloss``: its Phong exponent.
        emission: radiance factor of a lamp or a sky; 0 for everything that does not glow.
    """

    colour: Colour = (0.8, 0.8, 0.8)
    texture: UInt8 | None = None
    opacity: float = 1.0
    shine: float = 0.0
    gloss: float = 10.0
    emission: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """A triangle mesh in its own frame.

    Attributes:
        vertices: float32 (N, 3) metres.
        normals: float32 (N, 3), unit length, of the shaded surface.
        uv: float32 (N, 2) texture coordinates.
        faces: int32 (M, 3) into the vertices.
        material_index: int32 (M,) into ``materials``.
    """

    vertices: Float32
    normals: Float32
    uv: Float32
    faces: Int32
    material_index: Int32
    materials: tuple[Material, ...]
