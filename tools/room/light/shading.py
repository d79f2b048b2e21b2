"""The colour of what a ray meets.

Vectors of many rays are held as three rows here, (3, N): every step then runs over whole rows.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Int64, UInt8
from sceneq_tools.room.light.corner_tables import Corners, CornerTables
from sceneq_tools.room.light.highlights import DULL, Glances, Lamps, highlights
from sceneq_tools.room.light.raycaster import Hits
from sceneq_tools.room.light.surfaces import Surfaces
from sceneq_tools.room.light.vectors import dot, length
from sceneq_tools.room.textures.linear import LINEAR_OF_BYTE

FLATTEST = 0.2  # a texture is not read coarser than at this cosine: grazing floors would blur


@dataclass(frozen=True, slots=True, eq=False)
class Shaded:
    """Per ray: what the surface sends back.

    Attributes:
        radiance: float32 (3, N) of the surface as far as it covers, and of its highlights.
        cover: float32 (N,) share of what is behind that it hides; 0 where it is cut out.
        hole: bool (N,) cut out: as if nothing were there.
        cosine: float32 (N,) between ray and surface normal, 0 to 1.
    """

    radiance: Float32
    cover: Float32
    hole: Bool
    cosine: Float32


@dataclass(frozen=True, slots=True, eq=False)
class Shader:
    """Surfaces under light."""

    tables: CornerTables
    surfaces: Surfaces
    lamps: Lamps

    def shade(self, hits: Hits, origin: Float32, directions: Float32, pixel: float) -> Shaded:
        """Shade hits, all of which have a face.

        Args:
            origin: float32 (3,) the camera; ``directions``: float32 (N, 3).
            pixel: width of a pixel at one length of ``directions``, metres.
        """
        ahead = np.ascontiguousarray(directions.T)
        facing = dot(np.ascontiguousarray(hits.normal.T), ahead)
        far = length(ahead)
        cosine: Float32 = np.divide(np.abs(facing), far)
        corners = self.tables.corners(hits.face, (facing > 0).view(np.int8))
        weights = _weights(hits.uv)
        normals, uv = self.tables.surface(corners, weights)
        received, seen = self.tables.light(corners, weights)
        footprint = np.divide(hits.distance, np.maximum(cosine, np.float32(FLATTEST)))
        footprint *= np.float32(pixel)
        radiance, hole = self._paint(corners, uv, footprint)
        radiance *= self._lit(received, corners.material)
        cover = self._cover(corners.material, hole, cosine)
        radiance *= cover
        shine = self.surfaces.shine.take(corners.material)
        shine[hole] = 0
        if (shine > DULL).any():
            at = ahead * hits.distance + origin[:, None]
            normals *= np.where(facing > 0, np.float32(-1), np.float32(1))
            glances = Glances(at, np.divide(ahead, -far), normals, seen)
            gloss = self.surfaces.gloss.take(corners.material)
            radiance += highlights(self.lamps, glances, shine, gloss)
        return Shaded(radiance, cover, hole, cosine)

    def _lit(self, received: Float32, material: Int64) -> Float32:
        """Return what a white surface sends back, or what it glows with itself, in place."""
        received *= np.float32(1 / np.pi)
        glow = self.surfaces.emission.take(material)
        glowing = np.flatnonzero(glow)
        received[:, glowing] = glow[glowing]
        return received

    def _paint(self, corners: Corners, uv: Float32, footprint: Float32) -> tuple[Float32, Bool]:
        """Return the linear colour (3, N) of the surface, and where its texture is cut out."""
        material, surfaces = corners.material, self.surfaces
        texels = footprint * corners.texels_per_m * surfaces.shrunk.take(material)
        level = np.rint(np.log2(np.maximum(texels, np.float32(1e-3)))).astype(np.int64)
        read = surfaces.atlas.read(surfaces.texture.take(material), uv.T, level)
        colour = np.ascontiguousarray(_light_of(read).T)[:3]
        colour *= surfaces.colour.take(material, axis=1)
        return colour, read[:, 3] < 128

    def _cover(self, material: Int64, hole: Bool, cosine: Float32) -> Float32:
        """Glass hides more at grazing angles (Schlick 1994, 10.1111/1467-8659.1330233)."""
        cover = self.surfaces.opacity.take(material)
        glass = np.flatnonzero(cover < 1)
        opacity, left = cover[glass], 1 - np.minimum(cosine[glass], 1)
        mirrored = np.float32(0.04) + np.float32(0.96) * left**5
        cover[glass] = opacity + (1 - opacity) * mirrored
        cover[hole] = 0
        return cover


def _light_of(texels: UInt8) -> Float32:
    light: Float32 = np.asarray(cv2.LUT(texels[None], LINEAR_OF_BYTE[None]), np.float32)[0]
    return light


def _weights(uv: Float32) -> Float32:
    """Return (3, N) from the weights of the second and third corner."""
    weights: Float32 = np.empty((3, len(uv)), np.float32)
    weights[1:] = uv.T
    np.subtract(1, weights[1] + weights[2], out=weights[0])
    return weights
