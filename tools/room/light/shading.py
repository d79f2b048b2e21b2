"""The colour of what a ray meets."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Int32
from sceneq_tools.room.light.illumination import PlaceLight, radiances
from sceneq_tools.room.light.raycaster import Hits
from sceneq_tools.room.light.stage import Stage
from sceneq_tools.room.light.surfaces import Surfaces
from sceneq_tools.room.room import Light
from sceneq_tools.room.textures.linear import LINEAR_OF_BYTE

DULL = 0.04  # weaker highlights are not computed
SOFTEST = 4.0
SHARPEST = 64.0  # larger exponents make a highlight smaller than the lamp it mirrors
FLATTEST = 0.2  # a texture is not read coarser than at this cosine: grazing floors would blur


@dataclass(frozen=True, slots=True, eq=False)
class Lamps:
    """The lights as highlights see them.

    Attributes: float32 (L, 3) ``centres`` and ``power`` (radiance times area).
    """

    centres: Float32
    power: Float32


@dataclass(frozen=True, slots=True, eq=False)
class Shaded:
    """Per ray: what the surface sends back.

    Attributes:
        body: float32 (N, 3) radiance of the surface itself; ``highlight``: float32 (N, 3).
        cover: float32 (N,) share of what is behind that it hides; 0 where it is cut out.
        hole: bool (N,) cut out: as if nothing were there.
        cosine: float32 (N,) between ray and surface normal, 0 to 1.
    """

    body: Float32
    highlight: Float32
    cover: Float32
    hole: Bool
    cosine: Float32


def lamps(lights: Sequence[Light]) -> Lamps:
    """Return centres and powers of rectangles."""
    centres = [light.corner + (light.edge_u + light.edge_v) / 2 for light in lights]
    areas = [np.linalg.norm(np.cross(light.edge_u, light.edge_v)) for light in lights]
    power = radiances(lights) * np.array(areas, np.float32)[:, None]
    return Lamps(np.array(centres, np.float32).reshape(-1, 3), power)


@dataclass(frozen=True, slots=True, eq=False)
class Shader:
    """Surfaces under light."""

    stage: Stage
    surfaces: Surfaces
    light: PlaceLight
    lamps: Lamps

    def shade(self, hits: Hits, origin: Float32, directions: Float32, pixel: float) -> Shaded:
        """Shade hits, all of which have a face.

        Args:
            origin: float32 (3,) the camera; ``directions``: float32 (N, 3).
            pixel: width of a pixel at one length of ``directions``, metres.
        """
        stage, weights = self.stage, _weights(hits.uv)
        corners = stage.faces.take(hits.face, axis=0)
        material = stage.material.take(hits.face)
        facing = np.einsum("ij,ij->i", hits.normal, directions)
        cosine = np.abs(facing) / np.maximum(_length(directions), np.float32(1e-9))
        colour, hole = self._paint(hits, material, corners, weights, cosine, pixel)
        places = stage.place_of_corner.take(hits.face, axis=0)
        places += ((facing > 0) * stage.place_starts[-1])[:, None]
        received = _mixed(self.light.irradiance, places, weights) * np.float32(1 / np.pi)
        glow = self.surfaces.emission.take(material)
        glowing = np.flatnonzero(glow > 0)
        received[glowing] = glow[glowing, None]
        colour *= received
        highlight = np.zeros_like(colour)
        shiny = np.flatnonzero((self.surfaces.shine.take(material) > DULL) & ~hole)
        if len(shiny):
            normals = _mixed(self.stage.normals, corners[shiny], weights[shiny])
            normals *= np.where(facing[shiny] > 0, np.float32(-1), np.float32(1))[:, None]
            seen = _mixed(self.light.seen, places[shiny], weights[shiny])
            at = origin + directions[shiny] * hits.distance[shiny, None]
            out = -directions[shiny] / _length(directions[shiny])[:, None]
            highlight[shiny] = self._highlights(at, out, _unit(normals), seen, material[shiny])
        return Shaded(colour, highlight, self._cover(material, hole, cosine), hole, cosine)

    def _paint(
        self,
        hits: Hits,
        material: Int32,
        corners: Int32,
        weights: Float32,
        cosine: Float32,
        pixel: float,
    ) -> tuple[Float32, Bool]:
        """Return the linear colour of the surface, and where its texture is cut out."""
        colour = self.surfaces.colour.take(material, axis=0)
        hole = np.zeros(len(material), bool)
        texture = self.surfaces.texture.take(material)
        some = np.flatnonzero(texture >= 0)
        if len(some):
            uv = _mixed(self.stage.uv, corners[some], weights[some])
            footprint = hits.distance[some] * pixel / np.maximum(cosine[some], FLATTEST)
            texels = self.stage.texels_per_m[hits.face[some]] * self.surfaces.shrunk[material[some]]
            level = np.log2(np.maximum(footprint * texels, np.float32(1e-3)))
            read = self.surfaces.atlas.read(texture[some], uv, np.rint(level).astype(np.int32))
            colour[some] *= LINEAR_OF_BYTE[read[:, :3]]
            hole[some] = read[:, 3] < 128
        return colour, hole

    def _cover(self, material: Int32, hole: Bool, cosine: Float32) -> Float32:
        """Glass hides more at grazing angles (Schlick 1994, 10.1111/1467-8659.1330233)."""
        opacity = self.surfaces.opacity.take(material)
        cover = (~hole).astype(np.float32)
        glass = np.flatnonzero((opacity < 1) & ~hole)
        mirrored = np.float32(0.04) + np.float32(0.96) * (1 - np.minimum(cosine[glass], 1)) ** 5
        cover[glass] = opacity[glass] + (1 - opacity[glass]) * mirrored
        return cover

    def _highlights(
        self, at: Float32, out: Float32, normals: Float32, seen: Float32, material: Int32
    ) -> Float32:
        """Blinn-Phong at the lights' centres, as far as each light is seen from there."""
        gloss = np.clip(self.surfaces.gloss[material], SOFTEST, SHARPEST)
        strength = self.surfaces.shine[material] * (gloss + 2) * np.float32(0.35 / (8 * np.pi))
        total = np.zeros_like(at)
        for k, (centre, power) in enumerate(zip(self.lamps.centres, self.lamps.power, strict=True)):
            if seen[:, k].any():
                lobe = _lobe(centre - at, out, normals, gloss) * strength * seen[:, k]
                total += lobe[:, None] * power
        return total


def _weights(uv: Float32) -> Float32:
    weights = np.empty((len(uv), 3), np.float32)
    weights[:, 1:] = uv
    np.subtract(1, uv[:, 0] + uv[:, 1], out=weights[:, 0])
    return weights


def _mixed(table: Float32, corners: Int32, weights: Float32) -> Float32:
    """Return rows of ``table`` at three corners, weighted."""
    mixed = table.take(corners[:, 0], axis=0) * weights[:, :1]
    mixed += table.take(corners[:, 1], axis=0) * weights[:, 1:2]
    mixed += table.take(corners[:, 2], axis=0) * weights[:, 2:]
    return mixed


def _length(vectors: Float32) -> Float32:
    length: Float32 = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return length


def _unit(vectors: Float32) -> Float32:
    return np.divide(vectors, np.maximum(_length(vectors), 1e-9)[:, None], dtype=np.float32)


def _lobe(to_light: Float32, out: Float32, normal: Float32, gloss: Float32) -> Float32:
    squared = np.einsum("ij,ij->i", to_light, to_light)
    incoming = to_light / np.sqrt(np.maximum(squared, np.float32(1e-9)))[:, None]
    half = incoming + out
    half /= np.maximum(_length(half), np.float32(1e-9))[:, None]
    arriving = np.maximum(np.einsum("ij,ij->i", normal, incoming), 0)
    near = np.maximum(np.einsum("ij,ij->i", normal, half), np.float32(1e-6))
    powered = cv2.exp(gloss * cv2.log(near).ravel()).ravel() if len(near) else near
    lobe: Float32 = arriving * powered / np.maximum(squared, np.float32(0.04))
    return lobe
