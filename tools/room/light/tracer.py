"""Rays through a lit room: what they see, glass and cut-out leaves included."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float32, Int32
from sceneq_tools.room.light.raycaster import STEP_M, Hits, Raycaster
from sceneq_tools.room.light.shading import Shader

LAYERS = 6  # surfaces that are looked through
OPAQUE = 0.99


@dataclass(frozen=True, slots=True, eq=False)
class Traced:
    """What N rays see.

    Attributes:
        radiance: float32 (N, 3) linear.
        distance: float32 (N,) of the first surface that is not cut out there; 0 for none.
        face: int32 (N,) its face, -1 for none.
        cosine: float32 (N,) between the ray and its normal.
    """

    radiance: Float32
    distance: Float32
    face: Int32
    cosine: Float32


@dataclass(frozen=True, slots=True, eq=False)
class Tracer:
    """Casts rays on all cores, then shades them in blocks on threads."""

    raycaster: Raycaster
    shader: Shader
    threads: ThreadPoolExecutor
    block: int = 16384

    def trace(self, origin: Float32, directions: Float32, pixel: float) -> Traced:
        """Follow rays from the camera; see ``Shader.shade`` for ``pixel``."""
        hits = self.raycaster.nearest(origin, directions)
        traced, passing = self._first(hits, origin, directions, pixel)
        rays = np.flatnonzero(passing > 1 - OPAQUE).astype(np.int32)
        reached = hits.distance[rays]
        for _ in range(LAYERS - 1):
            if not len(rays):
                break
            hits = self._behind(origin, directions[rays], reached + np.float32(STEP_M))
            met = hits.face >= 0
            rays, hits = rays[met], _chosen(hits, met)
            self._add(traced, passing, rays, hits, origin, directions[rays], pixel)
            on = passing[rays] > 1 - OPAQUE
            rays, reached = rays[on], hits.distance[on]
        return traced

    def _behind(self, origin: Float32, directions: Float32, start: Float32) -> Hits:
        hits = self.raycaster.nearest(origin + directions * start[:, None], directions)
        return Hits(hits.distance + start, hits.face, hits.uv, hits.normal)

    def _first(
        self, hits: Hits, origin: Float32, directions: Float32, pixel: float
    ) -> tuple[Traced, Float32]:
        """Return what the first layer gives, and the share of light that passes it."""
        count = len(directions)
        radiance, passing = np.zeros((count, 3), np.float32), np.zeros(count, np.float32)
        distance, cosine = np.zeros(count, np.float32), np.zeros(count, np.float32)
        face = np.full(count, -1, np.int32)

        def block(at: slice) -> None:
            part, ahead = _chosen(hits, at), directions[at]
            missed = part.face < 0
            part.face[missed] = 0
            part.distance[missed] = 0
            shaded = self.shader.shade(part, origin, ahead, pixel)
            shaded.cover[missed] = 0
            radiance[at] = shaded.radiance.T
            radiance[at][missed] = 0
            passing[at] = np.where(missed, 0, 1 - shaded.cover)
            there = ~(missed | shaded.hole)
            face[at] = np.where(there, part.face, -1)
            distance[at] = np.where(there, part.distance, 0)
            cosine[at] = np.where(there, shaded.cosine, 0)

        list(self.threads.map(block, self._blocks(count)))
        return Traced(radiance, distance, face, cosine), passing

    def _add(
        self,
        traced: Traced,
        passing: Float32,
        rays: Int32,
        hits: Hits,
        origin: Float32,
        directions: Float32,
        pixel: float,
    ) -> None:
        """Add a layer behind others, in place, for the rays with these numbers."""

        def block(at: slice) -> None:
            part, ray, ahead = _chosen(hits, at), rays[at], directions[at]
            shaded = self.shader.shade(part, origin, ahead, pixel)
            traced.radiance[ray] += (shaded.radiance * passing[ray]).T
            passing[ray] *= 1 - shaded.cover
            first = ~shaded.hole & (traced.face[ray] < 0)
            traced.face[ray[first]] = part.face[first]
            traced.distance[ray[first]] = part.distance[first]
            traced.cosine[ray[first]] = shaded.cosine[first]

        list(self.threads.map(block, self._blocks(len(rays))))

    def _blocks(self, count: int) -> list[slice]:
        return [slice(i, i + self.block) for i in range(0, count, self.block)]


def _chosen(hits: Hits, index: slice | Int32 | Bool) -> Hits:
    return Hits(hits.distance[index], hits.face[index], hits.uv[index], hits.normal[index])
